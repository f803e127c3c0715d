#pragma once

#include <sqlite3.h>

#include <atomic>
#include <cstring>
#include <string>

namespace pliant::test {

/// A file system for SQLite that passes everything on to the usual one and fails when told: at the
/// n-th write, synchronisation or truncation from now on, once or from then on.
///
/// From then on is what a process sees that dies there: nothing that it does later reaches the
/// disk. Opened again through the usual file system, the files are as the crash left them.
///
/// One at a time; it must outlive the connections that use it.
class FaultyVfs {
 public:
  enum class Mode { kOnce, kFromThenOn };

  FaultyVfs() {
    real_ = sqlite3_vfs_find(nullptr);
    vfs_ = *real_;
    vfs_.zName = "pliant-faulty";
    vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
    vfs_.xOpen = &Open;
    vfs_.pAppData = this;
    current_ = this;
    sqlite3_vfs_register(&vfs_, 0);
  }
  ~FaultyVfs() {
    sqlite3_vfs_unregister(&vfs_);
    current_ = nullptr;
  }
  FaultyVfs(const FaultyVfs&) = delete;
  FaultyVfs& operator=(const FaultyVfs&) = delete;

  [[nodiscard]] std::string name() const { return vfs_.zName; }

  /// @param at     the how many-eth change from now on fails, from 1.
  /// @param error  SQLite's code; a write that fails with another code than SQLITE_FULL is torn:
  ///               half of it reaches the file.
  void FailAt(int at, int error, Mode mode) {
    error_ = error;
    mode_ = mode;
    changes_ = 0;
    fail_at_ = at;
  }
  void Heal() { fail_at_ = 0; }
  /// Changes since FailAt.
  [[nodiscard]] int changes() const { return changes_; }

 private:
  struct File {
    sqlite3_file base;
    sqlite3_io_methods methods;
    [[nodiscard]] sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  };

  static sqlite3_file* Real(sqlite3_file* file) { return reinterpret_cast<File*>(file)->real(); }

  bool Fails() {
    const int number = ++changes_;
    const int at = fail_at_;
    return at > 0 && (mode_ == Mode::kOnce ? number == at : number >= at);
  }

  static int Open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
    FaultyVfs& self = *current_;
    auto* mine = reinterpret_cast<File*>(file);
    mine->base.pMethods = nullptr;
    const int result = self.real_->xOpen(self.real_, name, mine->real(), flags, out_flags);
    if (mine->real()->pMethods == nullptr) return result;
    FillMethods(*mine);
    mine->base.pMethods = &mine->methods;
    return result;
  }

  static void FillMethods(File& file) {
    const sqlite3_io_methods& real = *file.real()->pMethods;
    file.methods = {};
    file.methods.iVersion = real.iVersion < 2 ? real.iVersion : 2;
    file.methods.xClose = [](sqlite3_file* f) { return Real(f)->pMethods->xClose(Real(f)); };
    file.methods.xRead = [](sqlite3_file* f, void* to, int size, sqlite3_int64 at) {
      return Real(f)->pMethods->xRead(Real(f), to, size, at);
    };
    file.methods.xWrite = &Write;
    file.methods.xTruncate = [](sqlite3_file* f, sqlite3_int64 size) {
      if (current_->Fails()) return current_->error_.load();
      return Real(f)->pMethods->xTruncate(Real(f), size);
    };
    file.methods.xSync = [](sqlite3_file* f, int flags) {
      if (current_->Fails()) return current_->error_.load();
      return Real(f)->pMethods->xSync(Real(f), flags);
    };
    file.methods.xFileSize = [](sqlite3_file* f, sqlite3_int64* size) {
      return Real(f)->pMethods->xFileSize(Real(f), size);
    };
    file.methods.xLock = [](sqlite3_file* f, int l) {
      return Real(f)->pMethods->xLock(Real(f), l);
    };
    file.methods.xUnlock = [](sqlite3_file* f, int l) {
      return Real(f)->pMethods->xUnlock(Real(f), l);
    };
    file.methods.xCheckReservedLock = [](sqlite3_file* f, int* out) {
      return Real(f)->pMethods->xCheckReservedLock(Real(f), out);
    };
    file.methods.xFileControl = [](sqlite3_file* f, int op, void* argument) {
      return Real(f)->pMethods->xFileControl(Real(f), op, argument);
    };
    file.methods.xSectorSize = [](sqlite3_file* f) {
      return Real(f)->pMethods->xSectorSize(Real(f));
    };
    file.methods.xDeviceCharacteristics = [](sqlite3_file* f) {
      return Real(f)->pMethods->xDeviceCharacteristics(Real(f));
    };
    file.methods.xShmMap = [](sqlite3_file* f, int page, int size, int extend, void volatile** to) {
      return Real(f)->pMethods->xShmMap(Real(f), page, size, extend, to);
    };
    file.methods.xShmLock = [](sqlite3_file* f, int offset, int n, int flags) {
      return Real(f)->pMethods->xShmLock(Real(f), offset, n, flags);
    };
    file.methods.xShmBarrier = [](sqlite3_file* f) { Real(f)->pMethods->xShmBarrier(Real(f)); };
    file.methods.xShmUnmap = [](sqlite3_file* f, int remove) {
      return Real(f)->pMethods->xShmUnmap(Real(f), remove);
    };
  }

  static int Write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 at) {
    FaultyVfs& self = *current_;
    const auto write = [&](int count) {
      return Real(file)->pMethods->xWrite(Real(file), bytes, count, at);
    };
    if (!self.Fails()) return write(size);
    // Only the first of those that fail is torn: later ones come from a process that is dead.
    const bool is_first = self.changes_ == self.fail_at_;
    if (is_first && self.error_ != SQLITE_FULL) static_cast<void>(write(size / 2));
    return self.error_;
  }

  static inline FaultyVfs* current_ = nullptr;
  sqlite3_vfs* real_ = nullptr;
  sqlite3_vfs vfs_{};
  std::atomic<int> changes_ = 0;
  std::atomic<int> fail_at_ = 0;
  std::atomic<int> error_ = SQLITE_IOERR_WRITE;
  std::atomic<Mode> mode_ = Mode::kOnce;
};

}  // namespace pliant::test
