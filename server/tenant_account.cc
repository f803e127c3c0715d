#include "server/tenant_account.h"

#include <algorithm>

namespace pliant::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

Error Exhausted(const std::string& what, std::int64_t used, std::int64_t allowed) {
  return {ErrorCode::kResourceExhausted,
          "your sessions would have " + std::to_string(used) + " " + what +
              " together; allowed are " + std::to_string(allowed) +
              ": delete a session, or ask for larger elements; waiting alone frees nothing",
          {}};
}

}  // namespace

void TenantAccount::Change(const SessionUsage& before, const SessionUsage& now) {
  const std::lock_guard lock(mutex_);
  usage_.vertices += now.vertices - before.vertices;
  usage_.bytes += now.bytes - before.bytes;
}

void TenantAccount::Charge(nanoseconds time, Clock::Time now) {
  if (limits_.compute_percent == 0) return;
  const std::lock_guard lock(mutex_);
  debt_ = DebtAt(now) + time;
  charged_ = now;
}

// What was spent, less what the clock has paid since.
nanoseconds TenantAccount::DebtAt(Clock::Time now) const {
  const nanoseconds paid = (now - charged_) / 100 * limits_.compute_percent;
  return std::max(nanoseconds(0), debt_ - paid);
}

Status TenantAccount::CheckCompute(Clock::Time now) const {
  if (limits_.compute_percent == 0) return {};
  const std::lock_guard lock(mutex_);
  const nanoseconds over = DebtAt(now) - limits_.compute_burst;
  if (over <= nanoseconds(0)) return {};
  Error error{ErrorCode::kResourceExhausted,
              "your sessions have used up their compute time, " +
                  std::to_string(limits_.compute_percent) +
                  " percent of a worker over the long run; try again later",
              {}};
  const nanoseconds wait = over * 100 / limits_.compute_percent;
  error.retry_after_ms = std::chrono::ceil<milliseconds>(wait).count();
  return error;
}

Status TenantAccount::CheckRoom(const SessionUsage& before, const SessionUsage& wanted) const {
  const std::lock_guard lock(mutex_);
  const std::int64_t vertices = usage_.vertices - before.vertices + wanted.vertices;
  const std::int64_t bytes = usage_.bytes - before.bytes + wanted.bytes;
  if (limits_.vertices_max != 0 && vertices > limits_.vertices_max) {
    return Exhausted("vertices", vertices, limits_.vertices_max);
  }
  if (limits_.bytes_max != 0 && bytes > limits_.bytes_max) {
    return Exhausted("bytes", bytes, limits_.bytes_max);
  }
  return {};
}

SessionUsage TenantAccount::usage() const {
  const std::lock_guard lock(mutex_);
  return usage_;
}

std::shared_ptr<TenantAccount> TenantAccounts::Of(const std::string& tenant) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<TenantAccount>& account = accounts_[tenant];
  if (account == nullptr) account = std::make_shared<TenantAccount>(limits_);
  return account;
}

}  // namespace pliant::server
