#include <fmt/format.h>

#include <algorithm>

#include "renderers/methods/method.h"
#include "renderers/scene/error.h"

// Every method once, in the order of the tables. A new method adds its name to this list.
#define OCCLAB_METHODS(METHOD) \
  METHOD(rtdo)                 \
  METHOD(ssao)                 \
  METHOD(s3ho)                 \
  METHOD(ssdo)                 \
  METHOD(ssbn)                 \
  METHOD(s3hogi)               \
  METHOD(ssdogi)               \
  METHOD(shadow_maps)          \
  METHOD(instant_radiosity) METHOD(rtgi_unoccluded) METHOD(rtgi_shaded)

namespace occlab {

#define DECLARE(name) MethodInfo name();
OCCLAB_METHODS(DECLARE)
#undef DECLARE

const std::vector<MethodInfo>& methods() {
#define CALL(name) name(),
  static const std::vector<MethodInfo> all = {OCCLAB_METHODS(CALL)};
#undef CALL
  return all;
}

const MethodInfo& find_method(const std::string& name) {
  const auto method = std::ranges::find(methods(), name, &MethodInfo::name);
  if (method != methods().end()) return *method;
  std::vector<std::string> names;
  for (const MethodInfo& info : methods()) names.push_back(info.name);
  throw InputError(fmt::format("unknown method '{}'{}", name, accepted_words(name, names)));
}

}  // namespace occlab
