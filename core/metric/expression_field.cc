#include "core/metric/expression_field.h"

#include <algorithm>
#include <array>
#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <utility>

#include "core/metric/saved_field.h"
#include "core/metric/shared_program.h"

namespace pliant {
namespace {

/// An expression that belongs to a field of the request.
Result<Expression> Parse(const std::string& text, const std::string& field) {
  Result<Expression> expression = Expression::Parse(text);
  if (expression.ok()) return expression;
  Error error = expression.error();
  error.message = field + ": " + error.message;
  error.field = field;
  return error;
}

/// A stream that writes numbers so that they can be read back, in no locale's way.
std::ostringstream MessageAt(Vec2 p, double time) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(std::numeric_limits<double>::max_digits10);
  out << "at the point (" << p.x << ", " << p.y << "), t = " << time << ", ";
  return out;
}

class TensorField final : public ExpressionField {
 public:
  TensorField(ExpressionMetric source, std::array<Expression, 3> entries, const Settings& settings)
      : ExpressionField(settings),
        source_(std::move(source)),
        entries_(std::move(entries)),
        shared_(SharedProgram::Make(
            std::array{&entries_[0].program(), &entries_[1].program(), &entries_[2].program()})) {}

 private:
  Metric Raw(Vec2 p) const {
    const double t = settings().time;
    if (shared_ && shared_->shares()) {
      const auto [m11, m12, m22] = shared_->Evaluate(p, t);
      return {m11, m12, m22};
    }
    return {entries_[0].Evaluate(p, t), entries_[1].Evaluate(p, t), entries_[2].Evaluate(p, t)};
  }

  std::optional<Metric> Evaluate(Vec2 p) const override {
    return AdmitTensor(Raw(p), settings().bounds);
  }

  BlockAnswers EvaluateBlock(std::span<const Vec2> points) const override {
    BlockAnswers answers;
    if (!shared_) {
      std::ranges::transform(points, answers.begin(), [this](Vec2 p) { return Evaluate(p); });
      return answers;
    }
    const auto [m11, m12, m22] = shared_->EvaluateBlock(points, settings().time);
    for (std::size_t i = 0; i < points.size(); ++i) {
      answers[i] = AdmitTensor({m11[i], m12[i], m22[i]}, settings().bounds);
    }
    return answers;
  }

  Error Describe(Vec2 p) const override {
    const Metric raw = Raw(p);
    std::ostringstream out = MessageAt(p, settings().time);
    out << "the tensor m11 = " << raw.m11 << ", m12 = " << raw.m12 << ", m22 = " << raw.m22;
    if (!IsFinite(raw)) {
      out << " is not finite";
    } else {
      const Eigenvalues eigenvalues = EigenvaluesOf(raw);
      out << " with eigenvalues " << eigenvalues.low << " and " << eigenvalues.high
          << " is not a metric: expected both positive, in [1e-150, 1e150] and near enough to each"
             " other for doubles; size_max replaces eigenvalues of 0, anisotropy_max bounds their"
             " ratio";
    }
    return {.code = ErrorCode::kExpressionValue, .message = out.str(), .field = "metric.m11"};
  }

  std::variant<ExpressionMetric, SizeMetric> Source() const override { return source_; }

  ExpressionMetric source_;
  std::array<Expression, 3> entries_;
  std::optional<SharedProgram> shared_;  // Of the entries, if they have no condition.
};

class SizeField final : public ExpressionField {
 public:
  SizeField(SizeMetric source, Expression size, const Settings& settings)
      : ExpressionField(settings),
        source_(std::move(source)),
        size_(std::move(size)),
        shared_(SharedProgram::Make(std::array{&size_.program()})) {}

 private:
  double Raw(Vec2 p) const {
    const double t = settings().time;
    return shared_ && shared_->shares() ? shared_->Evaluate(p, t)[0] : size_.Evaluate(p, t);
  }

  std::optional<Metric> Evaluate(Vec2 p) const override { return Admit(Raw(p)); }

  BlockAnswers EvaluateBlock(std::span<const Vec2> points) const override {
    BlockAnswers answers;
    if (!shared_) {
      std::ranges::transform(points, answers.begin(), [this](Vec2 p) { return Evaluate(p); });
      return answers;
    }
    const SharedProgram::Block sizes = shared_->EvaluateBlock(points, settings().time)[0];
    for (std::size_t i = 0; i < points.size(); ++i) answers[i] = Admit(sizes[i]);
    return answers;
  }

  std::optional<Metric> Admit(double size) const {
    const SizeBounds& bounds = settings().bounds;
    if (!(size > 0) && !(size == 0 && bounds.size_min > 0)) return {};
    if (bounds.size_max > 0) size = std::min(size, bounds.size_max);
    if (bounds.size_min > 0) size = std::max(size, bounds.size_min);
    const Metric metric = Metric::Isotropic(size);
    if (!IsPositiveDefinite(metric)) return {};
    return metric;
  }

  Error Describe(Vec2 p) const override {
    std::ostringstream out = MessageAt(p, settings().time);
    out << "the size is " << Raw(p)
        << "; expected a positive length, in [1e-75, 1e75] (or 0 if size_min is given, and infinity"
           " if size_max is)";
    return {.code = ErrorCode::kExpressionValue, .message = out.str(), .field = "metric.size"};
  }

  std::variant<ExpressionMetric, SizeMetric> Source() const override { return source_; }

  SizeMetric source_;
  Expression size_;
  std::optional<SharedProgram> shared_;
};

}  // namespace

Metric ExpressionField::At(Vec2 p, std::int32_t& /*hint*/) const {
  if (const std::optional<Metric> metric = Evaluate(p)) return *metric;
  Remember(p);
  return settings_.fallback;
}

void ExpressionField::AtEach(std::span<const Vec2> points, std::span<std::int32_t> /*hints*/,
                             std::span<Metric> metrics) const {
  for (std::size_t begin = 0; begin < points.size(); begin += kBlockLength) {
    const auto block = points.subspan(begin, std::min(kBlockLength, points.size() - begin));
    const BlockAnswers answers = EvaluateBlock(block);
    for (std::size_t i = 0; i < block.size(); ++i) {
      if (!answers[i]) Remember(block[i]);
      metrics[begin + i] = answers[i].value_or(settings_.fallback);
    }
  }
}

void ExpressionField::Remember(Vec2 p) const {
  while (busy_.test_and_set(std::memory_order_acquire)) {
  }
  const bool is_lower =
      !failed_at_ || p.x < failed_at_->x || (p.x == failed_at_->x && p.y < failed_at_->y);
  if (is_lower) failed_at_ = p;
  busy_.clear(std::memory_order_release);
}

Status ExpressionField::status() const {
  if (failed_at_) return Describe(*failed_at_);
  return {};
}

Status ExpressionField::Save(ByteWriter& writer) const {
  const std::variant<ExpressionMetric, SizeMetric> source = Source();
  if (const auto* tensor = std::get_if<ExpressionMetric>(&source)) {
    PutFieldKind(SavedFieldKind::kTensorExpression, writer);
    for (const std::string& text : {tensor->m11, tensor->m12, tensor->m22}) writer.PutText(text);
  } else {
    PutFieldKind(SavedFieldKind::kSizeExpression, writer);
    writer.PutText(std::get<SizeMetric>(source).size);
  }
  writer.Put(settings_.time);
  PutBounds(settings_.bounds, writer);
  for (const double entry :
       {settings_.fallback.m11, settings_.fallback.m12, settings_.fallback.m22}) {
    writer.Put(entry);
  }
  return {};
}

std::size_t ExpressionField::bytes() const {
  constexpr std::size_t kProgramBytes = 4096;  // Three short programs, and what they share.
  return kProgramBytes;
}

Result<std::unique_ptr<ExpressionField>> MakeTensorField(
    const ExpressionMetric& metric, const ExpressionField::Settings& settings) {
  PLIANT_ASSIGN_OR_RETURN(Expression m11, Parse(metric.m11, "metric.m11"));
  PLIANT_ASSIGN_OR_RETURN(Expression m12, Parse(metric.m12, "metric.m12"));
  PLIANT_ASSIGN_OR_RETURN(Expression m22, Parse(metric.m22, "metric.m22"));
  return std::unique_ptr<ExpressionField>(std::make_unique<TensorField>(
      metric, std::array{std::move(m11), std::move(m12), std::move(m22)}, settings));
}

Result<std::unique_ptr<ExpressionField>> MakeSizeField(const SizeMetric& metric,
                                                       const ExpressionField::Settings& settings) {
  PLIANT_ASSIGN_OR_RETURN(Expression size, Parse(metric.size, "metric.size"));
  return std::unique_ptr<ExpressionField>(
      std::make_unique<SizeField>(metric, std::move(size), settings));
}

}  // namespace pliant
