#pragma once

#include <string>
#include <string_view>

namespace occlab {

/// To be called before a TOML text is parsed. toml++ limits how deep values nest, but not how many
/// tables a dotted key makes, and it prints and frees them by recursion. Throws InputError
/// "WHERE: ..." for a text beyond the limits `config_bytes` and `nesting`.
void check_toml_text(std::string_view text, const std::string& where);

}  // namespace occlab
