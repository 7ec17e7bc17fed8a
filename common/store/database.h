#pragma once

#include <concepts>
#include <memory>
#include <string>

#include "common/core/bytes.h"
#include "common/core/error.h"
#include "common/core/time.h"

struct sqlite3;
struct sqlite3_stmt;

namespace muster::store {

/// The file is no SQLite file, its pages do not fit together, or a statement does not fit its
/// tables.
class Damaged : public Failure {
 public:
  using Failure::Failure;
};

/// One SQLite file. Errors are thrown as `Failure`, in SQLite's own words.
class Database {
 public:
  /// Where the file is locked by somebody else, its statements wait so long before they throw.
  explicit Database(const std::string& path, Duration patience = {});

  void execute(const char* sql);

  /// A prepared statement; keeps the file open until it is gone, too. Values are given in order for
  /// its `?`s; then `step` goes to the next row and says whether there is one.
  class Statement {
   public:
    template <class... Values>
    Statement& with(const Values&... values) {
      reset();
      int at = 0;
      (bind(++at, values), ...);
      return *this;
    }
    bool step();
    /// Gives back what `with` holds, so that a file is not kept busy.
    void reset();

    std::int64_t integer(int column) const;
    std::uint64_t number(int column) const { return static_cast<std::uint64_t>(integer(column)); }
    std::string text(int column) const;
    Bytes blob(int column) const;
    void blob(int column, Bytes& into) const;

   private:
    friend class Database;
    struct Finalize {
      void operator()(sqlite3_stmt* s) const;
    };
    explicit Statement(sqlite3_stmt* s) : statement_(s) {}
    void check(int rc) const;
    void bind(int at, double v);
    void bind(int at, SimTime v) { bind(at, v.s()); }
    void bind(int at, const char* v);
    void bind(int at, const Bytes& v);  ///< must live until `step`
    void bind_integer(int at, std::int64_t v);
    void bind_null(int at);
    template <std::integral T>
    void bind(int at, T v) {
      bind_integer(at, static_cast<std::int64_t>(v));
    }
    template <class T>
    requires requires(const T& v) {
      *v;
      v.has_value();
    }
    void bind(int at, const T& v) { v.has_value() ? bind(at, *v) : bind_null(at); }

    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  };
  Statement prepare(const char* sql);

 private:
  struct Close {
    void operator()(sqlite3* db) const;
  };
  void check(int rc) const;

  std::unique_ptr<sqlite3, Close> db_;
};

}  // namespace muster::store
