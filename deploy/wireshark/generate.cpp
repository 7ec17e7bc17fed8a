// generate IDL… DECODER: muster.lua on stdout: the types of the IDL files as a Lua table, then the
// decoder that reads messages by it. Knows of IDL what ours uses: modules, structs, scoped names,
// sequences, strings and the basic types (idl/README.md).
#include <cctype>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

std::string read(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Words and single signs; comments, preprocessor lines and annotations are left out.
std::vector<std::string> tokens(const std::string& text) {
  std::vector<std::string> out;
  const auto is_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == ':' || c == '@';
  };
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '#' || text.compare(i, 2, "//") == 0) {
      i = std::min(text.find('\n', i), text.size());
    } else if (is_word(text[i])) {
      const std::size_t begin = i;
      while (i < text.size() && is_word(text[i])) ++i;
      if (text[begin] != '@') out.push_back(text.substr(begin, i - begin));
    } else {
      if (!std::isspace(static_cast<unsigned char>(text[i]))) out.emplace_back(1, text[i]);
      ++i;
    }
  }
  return out;
}

struct Member {
  std::string type;  // as the decoder knows it: a basic type or a struct's full name
  std::string name;
  bool sequence = false;
};

class Idl {
 public:
  void add(const std::string& path) {
    path_ = path;
    tokens_ = tokens(read(path));
    at_ = 0;
    while (at_ < tokens_.size()) definition();
  }

  /// `local structs = {["muster::wire::Vec3"] = {{"x", "double"}, …}, …}`
  void write(std::ostream& out) const {
    out << "local structs = {\n";
    for (const auto& [name, members] : structs_) {
      out << "  [\"" << name << "\"] = {";
      for (const Member& m : members) {
        out << "{\"" << m.name << "\", \"" << m.type << '"' << (m.sequence ? ", true" : "") << "},";
      }
      out << "},\n";
    }
    out << "}\n";
  }

 private:
  std::string next() {
    if (at_ >= tokens_.size()) throw std::runtime_error(path_ + ": ends in the middle");
    return tokens_[at_++];
  }
  void expect(const std::string& token) {
    const std::string found = next();
    if (found != token) {
      throw std::runtime_error(path_ + ": '" + token + "' is expected, not '" + found + "'");
    }
  }

  void definition() {
    const std::string what = next();
    if (what == "module") {
      modules_.push_back(next());
      expect("{");
    } else if (what == "struct") {
      structure();
    } else if (what == "}") {
      modules_.pop_back();
    } else if (what != ";") {
      throw std::runtime_error(path_ + ": '" + what + "' is not understood");
    }
  }

  std::string scope(std::size_t depth) const {
    std::string name;
    for (std::size_t i = 0; i < depth; ++i) name += modules_[i] + "::";
    return name;
  }

  void structure() {
    const std::string name = scope(modules_.size()) + next();
    expect("{");
    std::vector<Member> members;
    while (tokens_.at(at_) != "}") {
      Member m = member_type();
      m.name = next();
      expect(";");
      members.push_back(m);
    }
    expect("}");
    structs_[name] = members;
  }

  Member member_type() {
    if (tokens_.at(at_) != "sequence") return {type(), "", false};
    next();
    expect("<");
    Member m{type(), "", true};
    expect(">");
    return m;
  }

  std::string type() {
    static const std::map<std::string, std::string> kBasic{
        {"double", "double"}, {"float", "float"},   {"boolean", "boolean"},
        {"octet", "octet"},   {"string", "string"}, {"long", "int32"}};
    const std::string word = next();
    if (word == "unsigned") {
      if (next() == "short") return "uint16";
      if (tokens_.at(at_) != "long") return "uint32";
      next();
      return "uint64";
    }
    if (const auto basic = kBasic.find(word); basic != kBasic.end()) return basic->second;
    // As seen from here: the innermost module that has it.
    for (std::size_t depth = modules_.size() + 1; depth-- > 0;) {
      if (structs_.contains(scope(depth) + word)) return scope(depth) + word;
    }
    throw std::runtime_error(path_ + ": the type '" + word + "' is not known");
  }

  std::string path_;
  std::vector<std::string> tokens_, modules_;
  std::size_t at_ = 0;
  std::map<std::string, std::vector<Member>> structs_;
};

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 3) throw std::runtime_error("generate IDL… DECODER");
    Idl idl;
    for (int i = 1; i + 1 < argc; ++i) idl.add(argv[i]);
    std::cout
        << "-- Made from idl/ when Muster was built: Wireshark and tshark show every field of "
           "its messages.\n--\n--     wireshark -X lua_script:muster.lua air.pcapng\n\n";
    idl.write(std::cout);
    std::cout << read(argv[argc - 1]);
  } catch (const std::exception& e) {
    std::cerr << e.what() << '\n';
    return 1;
  }
}
