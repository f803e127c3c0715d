// Goal: no text crashes, hangs or leaves its memory, and what is accepted evaluates purely.
// Method: libFuzzer under AddressSanitizer and UBSan. Bytes below 64 stand for tokens, so that most
// inputs are nearly expressions; the others are taken as they are.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/check.h"
#include "core/metric/expression.h"
#include "core/metric/shared_program.h"

namespace {

constexpr const char* kTokens[] = {
    "x",    "y",    "t",    "pi",    "e",      "1",    "2",    "0.5",         "1e300", ".1",
    "+",    "-",    "*",    "/",     "^",      "(",    ")",    ",",           "?",     ":",
    "<",    ">",    "<=",   ">=",    "==",     "!=",   "&&",   "||",          "!",     " ",
    "sin(", "exp(", "log(", "sqrt(", "atan2(", "min(", "max(", "clamp(",      "pow(",  "mod(",
    "abs",  "x^2",  "(x",   "y)",    "?x:y",   "=",    ".",    "smoothstep(", "foo",   "#",
    "max",  "-x",   "+y",   "^-2",   "?1",     ":2",   ",0",   ",,",          "()",    "1e",
    "\n",   "&",    "|",    "$"};

std::string Decode(const std::uint8_t* data, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] < std::size(kTokens)) {
      text += kTokens[data[i]];
    } else {
      text += static_cast<char>(data[i]);
    }
  }
  return text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = Decode(data, size);
  const pliant::Result<pliant::Expression> expression = pliant::Expression::Parse(text);
  if (!expression.ok()) {
    const std::int64_t index = expression.error().index;
    PLIANT_CHECK(index >= 0 && index <= static_cast<std::int64_t>(text.size()), "index", index);
    return 0;
  }
  const auto shared = pliant::SharedProgram::Make(std::array{&expression->program()});
  for (const double x : {-1.5, 0.0, 0.25, 1e200}) {
    const double value = expression->Evaluate({x, 0.75}, 2);
    const double again = expression->Evaluate({x, 0.75}, 2);
    PLIANT_CHECK(value == again || (std::isnan(value) && std::isnan(again)), "x", x);
    if (!shared) continue;
    const double other = shared->Evaluate({x, 0.75}, 2)[0];
    PLIANT_CHECK(value == other || (std::isnan(value) && std::isnan(other)), "x", x);
  }
  return 0;
}
