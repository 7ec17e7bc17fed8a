#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/radio/config.h"

namespace muster::radio {

/// paper, wifi-5ghz, uwb, 900mhz.
const std::vector<std::string>& preset_names();

/// The radio of that name, its `range_m` what planners may count on; nullopt when there is none.
///
/// | | paper | wifi-5ghz | uwb | 900mhz |
/// |---|---|---|---|---|
/// | who hears | 5 m, line of sight [1] | path loss | path loss | path loss |
/// | transmits, dBm | | 15 | −14.3 [3] | 17 [4] |
/// | sensitivity, dBm | | −82 [2] | −93 [3] | −100 [4] |
/// | loss at 1 m, dB; exponent | | 47.2; 2.1 [5] | 45.6; 1.76 [6] | 31.5; 2.1 [5] |
/// | shadowing, dB; m | | 4; 10 [5] | 0.83 [6]; 10 [5] | 4; 10 [5] |
/// | a wall, dB | stops it | 20 [7] | 23 [7] | 6 [7] |
/// | bit rate, Mbit/s | no limit | 6 [2] | 6.8 [3] | 0.156 [4] |
///
/// 1. SLEI3D, Sec. V: range 5 m and line of sight.
/// 2. IEEE 802.11-2016, Sec. 17.3.10.2: 6 Mbit/s at −82 dBm with 10 % of 1000-byte frames lost.
///    Broadcast frames leave at the lowest mandatory rate. Overhead: preamble, DIFS, mean backoff.
/// 3. Decawave DW1000 data sheet, channel 5 at 6.8 Mbit/s; −41.3 dBm/MHz over 500 MHz is the legal
///    limit (FCC 15.519). Frames up to 1023 bytes; overhead: preamble of 128 symbols, SFD, header.
/// 4. Digi XBee-PRO DigiMesh 900 (XBP09-DP) data sheet: 17 dBm, 156 kbit/s, −100 dBm.
/// 5. 3GPP TR 38.901, UMi street canyon with line of sight (tables 7.4.1-1 and 7.5-6):
///    32.4 + 21 lg d + 20 lg f/GHz, σ 4 dB, correlation distance 10 m.
/// 6. Molisch et al., IEEE 802.15.4a channel model, final report, outdoor with line of sight.
/// 7. ITU-R P.2040 for 15 cm of concrete (ε 5.24, σ 0.0462 f^0.7822): what the material absorbs
///    and two faces reflect. The walls of a line that has them are counted, so the exponents are
///    those of a free line (Rhodes and Jacobsen, 5 GHz WLAN: alike with and without).
///
/// Our own choice, as no source says it for small robots: asymmetry 2 dB (1 for uwb), `fade_db` 2,
/// queue 200 ms, latencies, and the 900 MHz module's frames of 256 bytes with 2 ms each.
std::optional<ChannelConfig> preset(std::string_view name);

}  // namespace muster::radio
