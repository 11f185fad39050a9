# cmake -DOUTPUT=FILE -DROOT=DIR -P version.cmake
# Writes a C++ file with what this build is: the commit, and hashes of the sources that decide a
# cell's pixels and what is measured on them. Hashes, not the commit, are in identities: editing a
# README keeps everything.
function(hash_folder folder result)
  file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/${folder}/*)
  # Looks at what was measured, and changes nothing of it.
  list(FILTER sources EXCLUDE REGEX "^harness/(report/|history/|verbs/(report|history))")
  list(SORT sources)
  set(hashes "")
  foreach(source IN LISTS sources)
    file(SHA256 ${ROOT}/${source} hash)
    string(APPEND hashes "${source} ${hash}\n")
  endforeach()
  string(SHA256 hash "${hashes}")
  string(SUBSTRING ${hash} 0 16 hash)
  set(${result} ${hash} PARENT_SCOPE)
endfunction()

hash_folder(renderers renderers_hash)
hash_folder(harness harness_hash)

execute_process(
  COMMAND git -C ${ROOT} describe --always --exclude "*" --dirty --abbrev=12
  OUTPUT_VARIABLE commit
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit "unknown")
endif()

file(WRITE "${OUTPUT}.new" "#include \"harness/version.h\"

namespace occlab {

const std::string_view build_commit = \"${commit}\";
const std::string_view renderers_hash = \"${renderers_hash}\";
const std::string_view harness_hash = \"${harness_hash}\";

}  // namespace occlab
")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
