
-- Looks into every RTPS packet after Wireshark's own dissector: learns from discovery which writer
-- writes what, puts fragments together, and shows what a message of a known type holds.

local muster = Proto("muster", "Muster")

-- ---- fields: muster.beacon.pose.p.x, one per member of every message, by its place in the IDL

local fields, field_list = {}, {}

local makers = {
  double = ProtoField.double, float = ProtoField.float, boolean = ProtoField.bool,
  octet = ProtoField.uint8, string = ProtoField.string, int32 = ProtoField.int32,
  uint16 = ProtoField.uint16, uint32 = ProtoField.uint32, uint64 = ProtoField.uint64,
}

local function add_field(abbrev, name, make)
  if fields[abbrev] then return end
  fields[abbrev] = make("muster." .. abbrev, name)
  field_list[#field_list + 1] = fields[abbrev]
end

-- MapBlock: map_block
local function snake(name)
  return (name:gsub("(%l)(%u)", "%1_%2"):lower())
end

local function declare(prefix, struct)
  for _, member in ipairs(structs[struct]) do
    local name, kind, sequence = member[1], member[2], member[3]
    local abbrev = prefix .. "." .. name
    if sequence and kind == "octet" then
      add_field(abbrev, name, ProtoField.bytes)
    else
      if sequence then add_field(abbrev .. ".count", "how many", ProtoField.uint32) end
      if structs[kind] then declare(abbrev, kind) else add_field(abbrev, name, makers[kind]) end
    end
  end
end

local messages = {}  -- "muster::air::Beacon" = "beacon"
for struct, members in pairs(structs) do
  if members[1] and members[1][1] == "envelope" then
    messages[struct] = snake(struct:match("([^:]+)$"))
    declare(messages[struct], struct)
  end
end

add_field("type", "type", ProtoField.string)
add_field("topic", "topic", ProtoField.string)
add_field("partition", "partition", ProtoField.string)
add_field("bytes", "bytes of CDR", ProtoField.uint32)
add_field("fragments", "put together from fragments", ProtoField.uint32)
add_field("malformed", "malformed", ProtoField.string)
muster.fields = field_list

-- ---- CDR: little endian, aligned to a value's own size from behind the encapsulation

local sizes = {double = 8, float = 4, boolean = 1, octet = 1, int32 = 4, uint16 = 2, uint32 = 4, uint64 = 8}

local function take(cursor, length, alignment)
  local at = cursor.at + (alignment - cursor.at % alignment) % alignment
  if at + length > cursor.tvb:len() - 4 then error({ends_in = cursor.path}) end
  cursor.at = at + length
  return cursor.tvb(at + 4, length)
end

local function decode_string(tree, abbrev, cursor)
  local length = take(cursor, 4, 4):le_uint()
  local range = take(cursor, length, 1)
  tree:add(fields[abbrev], range, length > 0 and range:string():gsub("%z", "") or "")
end

local decode_struct

local function decode_value(tree, abbrev, name, kind, cursor)
  cursor.path = abbrev
  if structs[kind] then
    decode_struct(tree, abbrev, name, kind, cursor)
  elseif kind == "string" then
    decode_string(tree, abbrev, cursor)
  else
    tree:add_le(fields[abbrev], take(cursor, sizes[kind], sizes[kind]))
  end
end

local function decode_sequence(tree, abbrev, name, kind, cursor)
  cursor.path = abbrev
  local at = cursor.at
  local count = take(cursor, 4, 4)
  local n = count:le_uint()
  if kind == "octet" then
    if n > 0 then tree:add(fields[abbrev], take(cursor, n, 1)) end
    return
  end
  -- A count that the rest of the message cannot hold would keep us busy for nothing.
  if n > cursor.tvb:len() - at then error({ends_in = abbrev}) end
  local subtree = tree:add(muster, count, name .. ": " .. n)
  subtree:add_le(fields[abbrev .. ".count"], count)
  for i = 1, n do
    decode_value(subtree, abbrev, name .. "[" .. (i - 1) .. "]", kind, cursor)
  end
end

function decode_struct(tree, abbrev, name, struct, cursor)
  local start = math.min(cursor.at + 4, cursor.tvb:len() - 1)
  local subtree = tree:add(muster, cursor.tvb(start, 0), name)
  for _, member in ipairs(structs[struct]) do
    local decode = member[3] and decode_sequence or decode_value
    decode(subtree, abbrev .. "." .. member[1], member[1], member[2], cursor)
  end
end

local function show(tree, writer, tvb, fragments)
  local topic = messages[writer.type]
  if tvb:len() == 4 then  -- Fast DDS greets a new reader with an empty sample, which readers drop
    tree:add(muster, tvb(), "Muster greeting on " .. writer.topic)
    return
  end
  local subtree = tree:add(muster, tvb(), "Muster " .. writer.type:match("([^:]+)$"))
  subtree:add(fields.type, writer.type)
  subtree:add(fields.topic, writer.topic)
  if writer.partition then subtree:add(fields.partition, writer.partition) end
  subtree:add(fields.bytes, tvb:len())
  if fragments > 0 then subtree:add(fields.fragments, fragments) end
  local cursor = {tvb = tvb, at = 0, path = topic}
  local ok, problem = pcall(function()
    if tvb:len() < 4 or tvb(0, 2):uint() ~= 1 then error({ends_in = "encapsulation"}) end
    for _, member in ipairs(structs[writer.type]) do
      local decode = member[3] and decode_sequence or decode_value
      decode(subtree, topic .. "." .. member[1], member[1], member[2], cursor)
    end
  end)
  if not ok then
    local where = type(problem) == "table" and problem.ends_in or tostring(problem)
    subtree:add(fields.malformed, "ends within " .. where)
  end
end

-- ---- RTPS: who writes what, and what was written

local writers = {}    -- guid (hex) → {topic, type, partition}
local pieces = {}     -- guid and number of a sample → fragments so far
local assembled = {}  -- frame number → samples completed by it

local kPublications = "000003c2"
local kSubmessage = {data = 0x15, data_frag = 0x16}

local function cdr_string(range, at)
  local length = range(at, 4):le_uint()
  return length > 1 and range(at + 4, length - 1):string() or "", at + 4 + length
end

local function padded(at) return at + (4 - at % 4) % 4 end

local function parameters(range, from)
  local found, at = {}, from
  while at + 4 <= range:len() do
    local id, length = range(at, 2):le_uint(), range(at + 2, 2):le_uint()
    at = at + 4
    if id == 1 or at + length > range:len() then break end
    if length > 0 then found[id] = range(at, length) end
    at = at + length
  end
  return found, at
end

local function learn_writer(payload)
  local p = parameters(payload, 4)
  if not (p[0x05] and p[0x07] and p[0x5a]) then return end
  local writer = {topic = cdr_string(p[0x05], 0), type = cdr_string(p[0x07], 0)}
  if p[0x29] and p[0x29](0, 4):le_uint() > 0 then writer.partition = cdr_string(p[0x29], 4) end
  writers[p[0x5a]:bytes():tohex()] = writer
end

-- Behind inline QoS, if there is some.
local function payload_at(body, flags, at)
  if bit.band(flags, 0x02) == 0 then return at end
  local _, behind = parameters(body, at)
  return behind
end

local function on_data(body, flags, prefix, tree)
  if body:len() < 20 or bit.band(flags, 0x04) == 0 then return end
  local at = payload_at(body, flags, 4 + body(2, 2):le_uint())
  if at >= body:len() then return end
  local payload, entity = body(at), body(8, 4):bytes():tohex()
  if entity:lower() == kPublications then return learn_writer(payload) end
  local writer = writers[prefix .. entity]
  if writer and messages[writer.type] then show(tree, writer, payload:tvb(), 0) end
end

local function put_together(sample)
  local whole = ByteArray.new()
  for i = 1, sample.count do whole:append(sample.parts[i]) end
  whole:set_size(sample.size)
  return whole
end

local function on_fragment(body, flags, prefix, frame)
  if body:len() < 32 then return end
  local guid = prefix .. body(8, 4):bytes():tohex()
  local key = guid .. body(12, 8):bytes():tohex()
  local first, count = body(20, 4):le_uint(), body(24, 2):le_uint()
  local size, total = body(26, 2):le_uint(), body(28, 4):le_uint()
  local at = payload_at(body, flags, 4 + body(2, 2):le_uint())
  if size == 0 or at >= body:len() then return end
  local sample = pieces[key] or {size = total, count = math.ceil(total / size), have = 0, parts = {}}
  pieces[key] = sample
  if sample.complete then return end
  for i = 0, count - 1 do
    local length = math.min(size, total - (first - 1 + i) * size)
    if length > 0 and at + length <= body:len() and not sample.parts[first + i] then
      sample.parts[first + i] = body(at, length):bytes()
      sample.have = sample.have + 1
    end
    at = at + length
  end
  if sample.have < sample.count then return end
  assembled[frame] = assembled[frame] or {}
  table.insert(assembled[frame], {guid = guid, bytes = put_together(sample), fragments = sample.count})
  sample.complete, sample.parts = true, nil
end

local function walk(message, pinfo, tree)
  if message:len() < 20 or message(0, 4):string() ~= "RTPS" then return end
  local prefix, at = message(8, 12):bytes():tohex(), 20
  while at + 4 <= message:len() do
    local id, flags = message(at, 1):uint(), message(at + 1, 1):uint()
    if bit.band(flags, 0x01) == 0 then return end  -- nobody of ours is big endian
    local length = message(at + 2, 2):le_uint()
    at = at + 4
    if length == 0 or at + length > message:len() then length = message:len() - at end
    if length == 0 then return end
    if id == kSubmessage.data then
      on_data(message(at, length), flags, prefix, tree)
    elseif id == kSubmessage.data_frag and not pinfo.visited then
      on_fragment(message(at, length), flags, prefix, pinfo.number)
    end
    at = at + length
  end
end

local rtps = Field.new("rtps")

function muster.init()
  writers, pieces, assembled = {}, {}, {}
end

function muster.dissector(_, pinfo, tree)
  for _, info in ipairs({rtps()}) do
    walk(info.range, pinfo, tree)
  end
  for _, sample in ipairs(assembled[pinfo.number] or {}) do
    local writer = writers[sample.guid]
    if writer and messages[writer.type] then
      show(tree, writer, sample.bytes:tvb("Muster message"), sample.fragments)
    end
  end
end

register_postdissector(muster)
