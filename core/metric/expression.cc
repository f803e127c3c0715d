#include "core/metric/expression.h"

#include <muParserBase.h>

#include <algorithm>
#include <charconv>
#include <locale>
#include <numbers>
#include <optional>
#include <sstream>
#include <utility>

#include "core/metric/math_functions.h"

namespace pliant {
namespace {

constexpr std::string_view kDigits = "0123456789";
constexpr std::string_view kNameCharacters =
    "0123456789_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

/// The texts and numbers one after the other.
template <class... Parts>
std::string Join(const Parts&... parts) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  (out << ... << parts);
  return std::move(out).str();
}

Error SyntaxError(std::string message, std::size_t position) {
  return {.code = ErrorCode::kExpressionSyntax,
          .message = std::move(message),
          .index = static_cast<std::int64_t>(position)};
}

bool IsConstant(std::string_view name) { return name == "pi" || name == "e"; }
bool IsVariable(std::string_view name) { return name == "x" || name == "y" || name == "t"; }

Error UnknownName(std::string_view name, std::size_t position) {
  std::string functions;
  for (const MathFunction& function : MathFunctions()) {
    functions.append(functions.empty() ? " " : ", ").append(function.name);
  }
  return SyntaxError(
      Join("unknown name '", name, "' at position ", position,
           "; known are the variables x, y, t, the constants pi, e and the functions", functions),
      position);
}

/// The length of the number that `text` begins with, and its value; no locale takes part.
struct NumberToken {
  std::size_t length;
  double value;
};
std::optional<NumberToken> ReadNumber(std::string_view text) {
  // from_chars would also take "inf", "nan" and a minus sign, which are not numbers here.
  if (text.empty() || (text[0] != '.' && kDigits.find(text[0]) == text.npos)) return {};
  NumberToken number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number.value);
  if (error != std::errc()) return {};
  number.length = static_cast<std::size_t>(end - text.data());
  return number;
}

/// Checks names, numbers, characters and nesting before the parser sees the text, and returns the
/// text in the form that it wants: no space between a function's name and its parenthesis.
/// Positions stay the same.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  Result<std::string> Scan() {
    while (position_ < text_.size()) {
      const char c = text_[position_];
      if (c == '.' || kDigits.find(c) != kDigits.npos) {
        PLIANT_RETURN_IF_ERROR(ScanNumber());
      } else if (kNameCharacters.find(c) != kNameCharacters.npos) {
        PLIANT_RETURN_IF_ERROR(ScanName());
      } else {
        PLIANT_RETURN_IF_ERROR(ScanSymbol(c));
      }
    }
    return std::move(text_);
  }

 private:
  Status ScanNumber() {
    const std::string_view rest = std::string_view(text_).substr(position_);
    const std::optional<NumberToken> number = ReadNumber(rest);
    if (!number) {
      const std::string_view token = rest.substr(0, rest.find_first_not_of("0123456789.eE"));
      return SyntaxError(
          Join("'", token, "' at position ", position_, " is not a number that a double can hold"),
          position_);
    }
    position_ += number->length;
    return {};
  }

  Status ScanName() {
    const std::size_t begin = position_;
    position_ = std::min(text_.find_first_not_of(kNameCharacters, begin), text_.size());
    const std::string name = text_.substr(begin, position_ - begin);
    if (FindMathFunction(name) == nullptr) {
      if (IsVariable(name) || IsConstant(name)) return {};
      return UnknownName(name, begin);
    }
    const std::size_t open = text_.find_first_not_of(" \t\r\n", position_);
    if (open == text_.npos || text_[open] != '(') {
      return SyntaxError(Join("the function '", name, "' at position ", begin,
                              " needs its arguments in parentheses"),
                         begin);
    }
    const auto at = [&](std::size_t i) { return text_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::rotate(at(begin), at(position_), at(open));
    position_ = open;
    return {};
  }

  Status ScanSymbol(char c) {
    if (std::string_view("+-*/^(),?:<>=!&| \t\r\n").find(c) == std::string_view::npos) {
      const bool is_printable = c > ' ' && c <= '~';
      return SyntaxError(Join(is_printable ? Join("'", c, "'") : "a character", " at position ",
                              position_, " has no meaning in an expression"),
                         position_);
    }
    if (c == '(' && ++nesting_ > Expression::kNestingMax) {
      return Error{.code = ErrorCode::kTooLarge,
                   .message = Join("parentheses are nested more than ", Expression::kNestingMax,
                                   " deep at position ", position_),
                   .index = static_cast<std::int64_t>(position_)};
    }
    if (c == ')') --nesting_;
    const char next = position_ + 1 < text_.size() ? text_[position_ + 1] : '\0';
    if (c == '=' && next != '=') {
      return SyntaxError(
          Join("'=' at position ", position_, " would be an assignment; to compare, write '=='"),
          position_);
    }
    const bool is_pair = next == '=' && (c == '=' || c == '<' || c == '>' || c == '!');
    position_ += is_pair ? 2 : 1;
    return {};
  }

  std::string text_;
  std::size_t position_ = 0;
  int nesting_ = 0;
};

// Stand for the prefix operators in muParser's code; the bodies differ so that no linker can give
// them one address.
double Negate(double v) { return -v; }
double Keep(double v) { return v; }
double Not(double v) { return v == 0 ? 1 : 0; }

/// muParser, used to parse only: it turns the text into reverse Polish notation, which becomes an
/// ExpressionProgram. Its evaluator, which calls the C library's pow, never runs.
class Parser final : public mu::ParserBase {
 public:
  Parser() {
    EnableOptimizer(false);
    AddValIdent(ReadValue);
    Init();
  }

  /// Throws mu::ParserError.
  const mu::ParserByteCode& Compile(const std::string& text) {
    SetExpr(text);
    static_cast<void>(GetUsedVar());  // Compiles, and does not evaluate.
    return GetByteCode();
  }

  const double* x() const { return &x_; }
  const double* y() const { return &y_; }

 private:
  static int ReadValue(const mu::char_type* text, int* position, mu::value_type* value) {
    const std::optional<NumberToken> number = ReadNumber(text);
    if (!number) return 0;
    *position += static_cast<int>(number->length);
    *value = number->value;
    return 1;
  }

  // Placeholders: which function is meant travels in the user data.
  static double Unary(void*, double) { return 0; }
  static double Binary(void*, double, double) { return 0; }
  static double Ternary(void*, double, double, double) { return 0; }
  static double Fold(void*, const double*, int) { return 0; }

  void InitCharSets() override {
    DefineNameChars(kNameCharacters.data());
    DefineOprtChars("+-*/^?<>=!&|");
    DefineInfixOprtChars("+-!");
  }
  void InitFun() override {
    for (const MathFunction& function : MathFunctions()) {
      const std::string name(function.name);
      void* const data = const_cast<MathFunction*>(&function);
      if (function.unary != nullptr) DefineFunUserData(name, Unary, data);
      if (function.binary != nullptr) DefineFunUserData(name, Binary, data);
      if (function.ternary != nullptr) DefineFunUserData(name, Ternary, data);
      if (function.fold != nullptr) DefineFunUserData(name, Fold, data);
    }
  }
  void InitConst() override {
    DefineConst("pi", std::numbers::pi);
    DefineConst("e", std::numbers::e);
    DefineVar("x", &x_);
    DefineVar("y", &y_);
    DefineVar("t", &t_);
  }
  void InitOprt() override {
    DefineInfixOprt("-", Negate);
    DefineInfixOprt("+", Keep);
    DefineInfixOprt("!", Not);
  }

  double x_ = 0;
  double y_ = 0;
  double t_ = 0;
};

using Operator = ExpressionProgram::Operator;

std::optional<Operator> BinaryOperator(mu::ECmdCode code) {
  switch (code) {
    // clang-format off
    case mu::cmADD: return Operator::kAdd;
    case mu::cmSUB: return Operator::kSubtract;
    case mu::cmMUL: return Operator::kMultiply;
    case mu::cmDIV: return Operator::kDivide;
    case mu::cmPOW: return Operator::kPower;
    case mu::cmLT: return Operator::kLess;
    case mu::cmLE: return Operator::kLessEqual;
    case mu::cmGT: return Operator::kGreater;
    case mu::cmGE: return Operator::kGreaterEqual;
    case mu::cmEQ: return Operator::kEqual;
    case mu::cmNEQ: return Operator::kNotEqual;
    case mu::cmLAND: return Operator::kAnd;
    case mu::cmLOR: return Operator::kOr;
    default: return std::nullopt;
      // clang-format on
  }
}

/// Appends the call of a function or prefix operator.
void AddCall(const mu::SToken& token, ExpressionProgram& program) {
  const auto is = [&](double (*prefix)(double)) {
    return token.Fun.cb._pRawFun == reinterpret_cast<mu::erased_fun_type>(prefix);
  };
  if (token.Fun.cb._pUserData != nullptr) {
    const auto* function = static_cast<const MathFunction*>(token.Fun.cb._pUserData);
    program.Call(*function, std::abs(token.Fun.argc));
  } else if (is(Negate)) {
    program.Apply(Operator::kNegate);
  } else if (is(Not)) {
    program.Apply(Operator::kNot);
  } else {
    PLIANT_CHECK(is(Keep));
  }
}

/// Nothing if the code makes no sense.
std::optional<ExpressionProgram> Translate(const mu::ParserByteCode& code, const Parser& parser) {
  ExpressionProgram program;
  const mu::SToken* const tokens = code.GetBase();
  for (std::size_t i = 0; i < code.GetSize() && tokens[i].Cmd != mu::cmEND; ++i) {
    const mu::SToken& token = tokens[i];
    if (token.Cmd == mu::cmVAL) {
      program.Push(token.Val.data2);
    } else if (token.Cmd == mu::cmVAR) {
      program.Apply(token.Val.ptr == parser.x()   ? Operator::kX
                    : token.Val.ptr == parser.y() ? Operator::kY
                                                  : Operator::kT);
    } else if (token.Cmd == mu::cmIF) {
      program.If();
    } else if (token.Cmd == mu::cmELSE) {
      program.Else();
    } else if (token.Cmd == mu::cmENDIF) {
      program.EndIf();
    } else if (token.Cmd == mu::cmFUNC) {
      AddCall(token, program);
    } else if (const std::optional<Operator> op = BinaryOperator(token.Cmd)) {
      program.Apply(*op);
    } else {
      return std::nullopt;
    }
  }
  if (!program.Finish()) return std::nullopt;
  return program;
}

Error FromParser(const mu::ParserError& error, std::size_t length) {
  const int reported = error.GetPos();
  const std::size_t position =
      reported < 0 ? length : std::min(static_cast<std::size_t>(reported), length);
  const std::string token = error.GetToken().empty() ? "" : Join(" '", error.GetToken(), "'");
  const auto make = [&](auto... parts) { return SyntaxError(Join(parts...), position); };
  switch (error.GetCode()) {
    case mu::ecUNEXPECTED_EOF:
    case mu::ecEMPTY_EXPRESSION:
      return make("the expression ends too early, at position ", position);
    case mu::ecMISSING_PARENS:
      return make("a closing parenthesis is missing at position ", position);
    case mu::ecTOO_FEW_PARAMS:
      return make("too few arguments for the function", token, ", which ends at position ",
                  position);
    case mu::ecTOO_MANY_PARAMS:
      return make("too many arguments for the function", token, ", which ends at position ",
                  position);
    case mu::ecMISSING_ELSE_CLAUSE:
    case mu::ecMISPLACED_COLON:
    case mu::ecUNEXPECTED_CONDITIONAL:
      return make("incomplete conditional at position ", position,
                  "; write condition ? value : value");
    default:
      return make("unexpected", token.empty() ? " input" : token, " at position ", position,
                  "; is an operator, a value or a parenthesis missing before it?");
  }
}

}  // namespace

Result<Expression> Expression::Parse(std::string_view text) {
  if (text.size() > kLengthMax) {
    return Error{.code = ErrorCode::kTooLarge,
                 .message = Join("the expression has ", text.size(), " characters, at most ",
                                 kLengthMax, " are allowed"),
                 .index = static_cast<std::int64_t>(kLengthMax)};
  }
  PLIANT_ASSIGN_OR_RETURN(const std::string cleaned, Scanner(text).Scan());
  try {
    Parser parser;
    std::optional<ExpressionProgram> program = Translate(parser.Compile(cleaned), parser);
    if (!program) {
      return SyntaxError(
          Join("the expression must have one value, from at most ", ExpressionProgram::kDepthMax,
               " intermediate ones; is a comma outside a function's parentheses?"),
          0);
    }
    return Expression(std::string(text), *std::move(program));
  } catch (const mu::ParserError& error) {
    return FromParser(error, text.size());
  }
}

}  // namespace pliant
