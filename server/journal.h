#pragma once

#include <functional>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"

namespace pliant::server {

/// Where one session writes what must survive: a snapshot and records after it. It knows nothing of
/// what they mean.
///
/// *Threads*: one caller at a time; `done` comes once, from any thread, in the order of the calls.
class Journal {
 public:
  using Done = std::function<void(const Status&)>;

  struct Contents {
    Bytes snapshot;
    std::vector<Bytes> records;
  };

  virtual ~Journal() = default;

  /// Begins it. @param head  what a list shows of the session
  virtual void Create(Bytes head, Bytes snapshot, Done done) = 0;
  /// Adds records, all or none, and replaces the head.
  virtual void Append(std::vector<Bytes> records, Bytes head, Done done) = 0;
  /// What is there. @pre every Append is done
  virtual Result<Contents> Load() = 0;
  /// Ends it: nothing is left.
  virtual void Delete(Done done) = 0;
};

}  // namespace pliant::server
