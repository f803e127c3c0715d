#include "core/motion/replace_domain.h"

#include "core/motion/domain_swap.h"

namespace pliant {
namespace {

/// Begins anew whenever it is applied.
class Replacement final : public MeshChange {
 public:
  explicit Replacement(const Domain& domain) : domain_(domain) {}

  [[nodiscard]] bool replaces_domain() const override { return true; }

  Result<Outcome> Apply(MeshEdit& edit) override {
    DomainSwap swap(domain_, stop());
    Result<Outcome> outcome = swap.Apply(edit);
    report_ = swap.report();
    return outcome;
  }

  [[nodiscard]] const DomainReport& report() const { return report_; }

 private:
  const Domain& domain_;
  DomainReport report_;
};

}  // namespace

Result<DomainReport> ReplaceDomain(Remesher& remesher, const Domain& domain) {
  if (remesher.revision() == Revision::kNone) {
    return Error{ErrorCode::kRevisionNotFound,
                 "there is no revision yet whose domain could be replaced: create the session with "
                 "this domain, or advance first",
                 "domain"};
  }
  Replacement replacement(domain);
  PLIANT_RETURN_IF_ERROR(remesher.Apply(replacement));
  return replacement.report();
}

}  // namespace pliant
