#include "tests/unit/dds/idl_lint.h"

#include <algorithm>
// GCC 12 invents uninitialised values in <regex> under sanitizers (its bug 105562).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <regex>
#include <utility>

namespace muster::test {
namespace {

struct Rule {
  const char* pattern;
  const char* message;
};

const Rule kRules[] = {
    {R"(@(optional|appendable|mutable|id|key)\b)",
     "not @optional, @appendable, @mutable, @id or @key: the vendors differ, and keys reorder"},
    {R"(\b(map\s*<|wstring|wchar|bitmask|bitset|any\b|fixed\s*<))",
     "not map, wstring, bitmask and the like: one vendor or the other cannot"},
    {R"(\bu?int(8|16|32|64)_t\b)",
     "not int32_t and the like: fastddsgen knows `long`, `unsigned long long` …"},
    {R"(\bstring\s*(<[^>]*>)?\s+\w+\s*\[)",
     "no array of string: fastddsgen writes it and never reads it"},
    {R"(\b(class|namespace|template|operator|new|delete|this|private|public|protected|virtual|friend|using|register|int|auto|explicit|typename|static|signed|volatile|inline|export|and|or|not|xor)\s*(\[[^\]]*\])?\s*[;,])",
     "a C++ keyword cannot name a member"},
};

/// Comments become spaces; lines stay where they are.
std::string without_comments(std::string text) {
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] != '/' || (text[i + 1] != '/' && text[i + 1] != '*')) continue;
    const bool line = text[i + 1] == '/';
    std::size_t end = text.find(line ? "\n" : "*/", i + 2);
    if (end == std::string::npos) end = text.size();
    if (!line && end != text.size()) end += 2;
    for (std::size_t j = i; j < end; ++j) {
      if (text[j] != '\n') text[j] = ' ';
    }
    i = end - 1;
  }
  return text;
}

class Lint {
 public:
  Lint(std::string name, std::string text)
      : name_(std::move(name)), text_(without_comments(std::move(text))) {}

  std::vector<std::string> run() {
    for (const Rule& rule : kRules) forbid(rule);
    check_constants();
    check_structs();
    return std::move(findings_);
  }

 private:
  void report(std::ptrdiff_t at, const std::string& what) {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + at, '\n');
    findings_.push_back(name_ + ":" + std::to_string(line) + ": " + what);
  }

  template <class Handle>
  void each(const std::string& pattern, Handle handle) {
    const std::regex regex(pattern);
    for (std::sregex_iterator m(text_.begin(), text_.end(), regex), end; m != end; ++m) handle(*m);
  }

  void forbid(const Rule& rule) {
    each(rule.pattern, [&](const std::smatch& m) { report(m.position(), rule.message); });
  }

  void check_constants() {
    const std::size_t module = text_.find("module ");
    each(R"(\bconst\b)", [&](const std::smatch& m) {
      if (module != std::string::npos && m.position() > static_cast<std::ptrdiff_t>(module)) {
        report(m.position(), "a const inside a module cannot be a bound: put it before the module");
      }
    });
  }

  void check_structs() {
    each(R"(((?:@\w+\s+)*)struct\s+(\w+)\s*\{\s*([\w:]+\s+\w+))", [&](const std::smatch& m) {
      const std::string annotations = m[1], struct_name = m[2], first = m[3];
      if (annotations.find("@final") == std::string::npos) {
        report(m.position(), "struct " + struct_name + " is not @final");
      }
      const bool nested = annotations.find("@nested") != std::string::npos;
      if (!nested && !std::regex_match(first, std::regex(R"((wire::)?Envelope\s+envelope)"))) {
        report(m.position(), "struct " + struct_name + " does not start with `Envelope envelope`");
      }
    });
  }

  std::string name_, text_;
  std::vector<std::string> findings_;
};

}  // namespace

std::vector<std::string> lint_idl(const std::string& name, const std::string& text) {
  return Lint(name, text).run();
}

}  // namespace muster::test
