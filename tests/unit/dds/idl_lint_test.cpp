#include "tests/unit/dds/idl_lint.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace muster::test {
namespace {

std::string in_module(const std::string& text) {
  return "module muster { module air {\n" + text + "\n}; };\n";
}

std::vector<std::string> lint_member(const std::string& member) {
  return lint_idl("x.idl",
                  in_module("@final struct A { wire::Envelope envelope; " + member + " };"));
}

TEST_CASE("the wire keeps to what both vendors understand") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(MUSTER_SOURCE_DIR "/idl")) {
    if (entry.path().extension() != ".idl") continue;
    std::ifstream in(entry.path());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    ++files;
    for (const std::string& finding : lint_idl(entry.path().filename().string(), text)) {
      FAIL_CHECK(finding);
    }
  }
  CHECK(files >= 4);
}

TEST_CASE("the lint sees what only one vendor understands") {
  const std::string member =
      GENERATE(as<std::string>(), "@optional long a;", "@id(3) long a;", "@key long a;",
               "map<long, long> a;", "wstring a;", "bitmask a;", "string a[3];", "string<8> a[3];",
               "int32_t a;", "uint64_t a;", "long class;", "sequence<long> namespace;");
  CAPTURE(member);
  REQUIRE(lint_member(member).size() == 1);
  CHECK(lint_member(member)[0].rfind("x.idl:2: ", 0) == 0);
}

TEST_CASE("the lint sees structs that are not of our form") {
  const std::string text =
      GENERATE(as<std::string>(), "struct A { wire::Envelope envelope; };",
               "@final struct A { long a; wire::Envelope envelope; };",
               "@final @nested struct A { long a; }; @final struct B { A a; };",
               "@nested struct A { long a; };", "const long kMany = 3;");
  CAPTURE(text);
  CHECK(lint_idl("x.idl", in_module(text)).size() == 1);
  CHECK(lint_idl("x.idl", in_module("@mutable struct A { wire::Envelope envelope; };")).size() ==
        2);
}

TEST_CASE("the lint lets pass what is fine") {
  CHECK(lint_member("unsigned long long a; sequence<octet> b; string note; double c[3];").empty());
  CHECK(lint_member("long a; // @key, int32_t and map<a, b> in a comment\n").empty());
  CHECK(lint_idl("x.idl",
                 "const long kMany = 3;\n" + in_module("@final @nested struct V { long x; };"))
            .empty());
}

}  // namespace
}  // namespace muster::test
