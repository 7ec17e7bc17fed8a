#include "common/core/yaml.h"

#include <catch2/catch.hpp>

using namespace muster;

namespace {

YamlMap parse(const std::string& text) { return YamlMap(YAML::Load(text), "m.yaml", ""); }

}  // namespace

TEST_CASE("a misspelt key is an error with file, line and what is known") {
  YamlMap map = parse("a: 1\nrnage: 2\n");
  int a = 0;
  double range = 0;
  map.read("a", a);
  map.read("range", range);
  CHECK_THROWS_WITH(map.finish(), "m.yaml:2: rnage: unknown key; known here: a, range");
}

TEST_CASE("a value of the wrong kind names its line and key") {
  YamlMap map = parse("a: 1\nrange: wide\np: [1, .nan, 2]\n");
  double range = 0;
  Eigen::Vector3d p;
  CHECK_THROWS_WITH(map.read("range", range), "m.yaml:2: range: 'wide' is not a number");
  CHECK_THROWS_WITH(map.read("p", p), "m.yaml:3: p: must be finite");
  CHECK_THROWS_WITH(map.require("scene", range), "m.yaml:1: 'scene' is missing");
}

TEST_CASE("regress_a_key_that_is_no_word: is bad input, with its line") {
  YamlMap map = parse("a: 1\n? [b, c]\n: 2\n");
  int a = 0;
  map.read("a", a);
  CHECK_THROWS_WITH(map.finish(), "m.yaml:2: a key is one word, neither a list nor a mapping");
}
