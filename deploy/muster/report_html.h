#pragma once

#include <string>

namespace muster::command::html {

/// Text made safe between tags and inside quoted attributes.
std::string escape(const std::string& text);
/// At most `decimals` digits after the point, without trailing zeros: 3, 0.25, 12.5.
std::string number(double value, int decimals = 2);
/// "0:42", "12:05", "1:02:05".
std::string clock(double t_s);
/// "42 s", "12 min 5 s", "1 h 2 min".
std::string spoken(double t_s);

}  // namespace muster::command::html
