#include "common/store/database.h"

#include <sqlite3.h>

namespace muster::store {
namespace {

void check_of(sqlite3* db, int rc) {
  if (rc == SQLITE_OK) return;
  const int kind = rc & 0xff;
  if (kind == SQLITE_CORRUPT || kind == SQLITE_NOTADB) throw Damaged(sqlite3_errmsg(db));
  throw Failure(sqlite3_errmsg(db));
}

}  // namespace

void Database::Close::operator()(sqlite3* db) const { sqlite3_close_v2(db); }
void Database::Statement::Finalize::operator()(sqlite3_stmt* s) const { sqlite3_finalize(s); }

Database::Database(const std::string& path, Duration patience) {
  sqlite3* db = nullptr;
  const int rc = sqlite3_open(path.c_str(), &db);
  db_.reset(db);
  check(rc);
  check(sqlite3_busy_timeout(db, static_cast<int>(patience.us / 1000)));
}

void Database::check(int rc) const { check_of(db_.get(), rc); }

void Database::execute(const char* sql) {
  check(sqlite3_exec(db_.get(), sql, nullptr, nullptr, nullptr));
}

Database::Statement Database::prepare(const char* sql) {
  sqlite3_stmt* s = nullptr;
  const int rc = sqlite3_prepare_v2(db_.get(), sql, -1, &s, nullptr);
  if (rc == SQLITE_ERROR) throw Damaged(sqlite3_errmsg(db_.get()));
  check(rc);
  return Statement(s);
}

void Database::Statement::check(int rc) const { check_of(sqlite3_db_handle(statement_.get()), rc); }

bool Database::Statement::step() {
  const int rc = sqlite3_step(statement_.get());
  if (rc != SQLITE_ROW && rc != SQLITE_DONE) check(rc);
  return rc == SQLITE_ROW;
}

void Database::Statement::reset() {
  // Says again what the last step has already thrown.
  static_cast<void>(sqlite3_reset(statement_.get()));
}

std::int64_t Database::Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string Database::Statement::text(int column) const {
  const unsigned char* s = sqlite3_column_text(statement_.get(), column);
  return s ? reinterpret_cast<const char*>(s) : "";
}

Bytes Database::Statement::blob(int column) const {
  Bytes bytes;
  blob(column, bytes);
  return bytes;
}

void Database::Statement::blob(int column, Bytes& into) const {
  const auto* data =
      static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  if (data)
    into.assign(data, data + size);
  else
    into.clear();
}

void Database::Statement::bind(int at, double v) {
  check(sqlite3_bind_double(statement_.get(), at, v));
}
void Database::Statement::bind(int at, const char* v) {
  check(sqlite3_bind_text(statement_.get(), at, v, -1, SQLITE_TRANSIENT));
}
void Database::Statement::bind(int at, const Bytes& v) {
  check(sqlite3_bind_blob64(statement_.get(), at, v.data(), v.size(), SQLITE_STATIC));
}
void Database::Statement::bind_integer(int at, std::int64_t v) {
  check(sqlite3_bind_int64(statement_.get(), at, v));
}
void Database::Statement::bind_null(int at) { check(sqlite3_bind_null(statement_.get(), at)); }

}  // namespace muster::store
