-- onemap's datagrams in Wireshark and tshark (comms/PROTOCOL.md). Sealed ones are opened with what `onemapd --key-log FILE`
-- wrote; tags are checked. Install as ~/.local/lib/wireshark/plugins/onemap.lua, or:
--   tshark -X lua_script:share/wireshark/onemap.lua -o onemap.keys:FILE -r CAPTURE -V
local onemap = Proto("onemap", "onemap")
onemap.prefs.keys = Pref.string("Key log", "", "File that onemapd --key-log wrote")

local f = {
  version = ProtoField.uint8("onemap.version", "Version"),
  type = ProtoField.uint8("onemap.type", "Type"),
  sender = ProtoField.bytes("onemap.sender_index", "Sender's index"),
  receiver = ProtoField.bytes("onemap.receiver_index", "Receiver's index"),
  counter = ProtoField.uint64("onemap.counter", "Counter"),
  noise = ProtoField.bytes("onemap.noise", "Noise message"),
  mac1 = ProtoField.bytes("onemap.mac1", "mac1"),
  mac2 = ProtoField.bytes("onemap.mac2", "mac2"),
  nonce = ProtoField.bytes("onemap.nonce", "Nonce"),
  sealed = ProtoField.bytes("onemap.sealed", "Sealed"),
  tag = ProtoField.bytes("onemap.tag", "Tag"),
  incarnation = ProtoField.uint64("onemap.incarnation", "Incarnation"),
  of_receiver = ProtoField.uint64("onemap.receiver_incarnation", "Receiver's incarnation"),
  frame = ProtoField.string("onemap.frame", "Frame"),
  robot = ProtoField.string("onemap.robot", "Robot"),
  lane = ProtoField.uint8("onemap.lane", "Lane"),
  count = ProtoField.uint32("onemap.count", "Count"),
  sequence = ProtoField.uint32("onemap.sequence", "Sequence"),
  fragment = ProtoField.uint16("onemap.fragment", "Fragment"),
  fragments = ProtoField.uint16("onemap.fragments", "Fragments"),
  credit = ProtoField.uint32("onemap.credit", "Credit"),
  kind = ProtoField.uint16("onemap.kind", "Kind"),
  hops = ProtoField.uint8("onemap.hops", "Hops"),
  size = ProtoField.uint32("onemap.size", "Size of the record"),
  hash = ProtoField.uint64("onemap.hash", "Body hash", base.HEX),
  frontier = ProtoField.uint64("onemap.frontier", "Frontier digest", base.HEX),
  map = ProtoField.uint64("onemap.map", "Map digest", base.HEX),
  status = ProtoField.uint32("onemap.status", "Status counter"),
  flags = ProtoField.uint8("onemap.flags", "Flags", base.HEX),
  token = ProtoField.uint64("onemap.token", "Token"),
  word = ProtoField.string("onemap.word", "Word"),
  bytes = ProtoField.bytes("onemap.bytes", "Bytes"),
}
local fields = {}
for _, field in pairs(f) do fields[#fields + 1] = field end
onemap.fields = fields
local no_key = ProtoExpert.new("onemap.no_key", "no key of it in the key log", expert.group.UNDECODED, expert.severity.NOTE)
local bad_tag = ProtoExpert.new("onemap.bad_tag", "the tag is wrong", expert.group.CHECKSUM, expert.severity.WARN)
local bad_frame = ProtoExpert.new("onemap.bad_frame", "malformed frame", expert.group.MALFORMED, expert.severity.WARN)
onemap.experts = { no_key, bad_tag, bad_frame }

-- ChaCha20 and Poly1305 (RFC 8439), XChaCha20 (draft-irtf-cfrg-xchacha): Wireshark gives scripts no ciphers.
local band, bor, bxor, lshift, rshift = bit.band, bit.bor, bit.bxor, bit.lshift, bit.rshift
local rol = bit.rol

local function word_at(s, at)
  local a, b, c, d = s:byte(at, at + 3)
  return bor(a, lshift(b, 8), lshift(c, 16), lshift(d, 24))
end
local function word_bytes(w)
  return string.char(band(w, 255), band(rshift(w, 8), 255), band(rshift(w, 16), 255), band(rshift(w, 24), 255))
end
local function quarter(x, a, b, c, d)
  x[a] = bit.tobit(x[a] + x[b]); x[d] = rol(bxor(x[d], x[a]), 16)
  x[c] = bit.tobit(x[c] + x[d]); x[b] = rol(bxor(x[b], x[c]), 12)
  x[a] = bit.tobit(x[a] + x[b]); x[d] = rol(bxor(x[d], x[a]), 8)
  x[c] = bit.tobit(x[c] + x[d]); x[b] = rol(bxor(x[b], x[c]), 7)
end
local function rounds(x)
  for _ = 1, 10 do
    quarter(x, 1, 5, 9, 13); quarter(x, 2, 6, 10, 14); quarter(x, 3, 7, 11, 15); quarter(x, 4, 8, 12, 16)
    quarter(x, 1, 6, 11, 16); quarter(x, 2, 7, 12, 13); quarter(x, 3, 8, 9, 14); quarter(x, 4, 5, 10, 15)
  end
end
local function state(key, last) -- last: 16 bytes of counter and nonce
  local x = { 0x61707865, 0x3320646e, 0x79622d32, 0x6b206574 }
  for i = 0, 7 do x[5 + i] = word_at(key, 1 + 4 * i) end
  for i = 0, 3 do x[13 + i] = word_at(last, 1 + 4 * i) end
  return x
end
local function block(key, number, nonce)
  local x = state(key, word_bytes(number) .. nonce)
  local before = { table.unpack(x) }
  rounds(x)
  local out = {}
  for i = 1, 16 do out[i] = word_bytes(bit.tobit(x[i] + before[i])) end
  return table.concat(out)
end
local function chacha20(key, nonce, text)
  local out = {}
  for at = 1, #text, 64 do
    local stream = block(key, (at + 63) / 64, nonce)
    for i = at, math.min(at + 63, #text) do
      out[#out + 1] = string.char(bxor(text:byte(i), stream:byte(i - at + 1)))
    end
  end
  return table.concat(out)
end
local function hchacha20(key, nonce)
  local x = state(key, nonce)
  rounds(x)
  local out = {}
  for _, i in ipairs({ 1, 2, 3, 4, 13, 14, 15, 16 }) do out[#out + 1] = word_bytes(x[i]) end
  return table.concat(out)
end

-- Numbers modulo 2^130 - 5 in ten limbs of 13 bits, so that a double holds every sum of products.
local function limbs(s, with_top)
  local bits, out, have, at = 0, {}, 0, 1
  for i = 1, 10 do
    while have < 13 and at <= #s + (with_top and 1 or 0) do
      bits = bits + (at <= #s and s:byte(at) or 1) * 2 ^ have
      have = have + 8
      at = at + 1
    end
    out[i] = bits % 8192
    bits = math.floor(bits / 8192)
    have = math.max(0, have - 13)
  end
  return out
end
local function carry(h)
  for _ = 1, 2 do
    local over = 0
    for i = 1, 10 do
      local v = h[i] + over
      h[i] = v % 8192
      over = math.floor(v / 8192)
    end
    h[1] = h[1] + 5 * over
  end
end
local function poly1305(key, text)
  local clamped = {}
  for i = 1, 16 do
    local b = key:byte(i)
    if i == 4 or i == 8 or i == 12 or i == 16 then b = band(b, 15) end
    if i == 5 or i == 9 or i == 13 then b = band(b, 252) end
    clamped[i] = string.char(b)
  end
  local r, h = limbs(table.concat(clamped)), { 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 }
  for at = 1, #text, 16 do
    local m = limbs(text:sub(at, at + 15), true)
    for i = 1, 10 do h[i] = h[i] + m[i] end
    local product = {}
    for i = 1, 10 do
      local sum = 0
      for j = 1, 10 do
        local k = i - j + 1
        sum = sum + h[j] * (k >= 1 and r[k] or 5 * r[k + 10])
      end
      product[i] = sum
    end
    h = product
    carry(h)
  end
  carry(h)
  local g, over = {}, 5 -- h + 5 - 2^130, if that is not negative
  for i = 1, 10 do
    local v = h[i] + over
    g[i] = v % 8192
    over = math.floor(v / 8192)
  end
  if over > 0 then h = g end
  local bits, have, out, sum = 0, 0, {}, 0
  local limb = 1
  for i = 1, 16 do
    while have < 8 do
      bits = bits + h[limb] * 2 ^ have
      have = have + 13
      limb = limb + 1
    end
    sum = sum + bits % 256 + key:byte(16 + i)
    out[i] = string.char(sum % 256)
    sum = math.floor(sum / 256)
    bits = math.floor(bits / 256)
    have = have - 8
  end
  return table.concat(out)
end
local function padded(s) return s .. string.rep("\0", (16 - #s % 16) % 16) end
local function length(n) return word_bytes(n) .. "\0\0\0\0" end
-- The text, or nothing when the tag is wrong.
local function open(key, nonce, associated, sealed)
  local text, tag = sealed:sub(1, -17), sealed:sub(-16)
  local one_time = block(key, 0, nonce):sub(1, 32)
  local mac = poly1305(one_time, padded(associated) .. padded(text) .. length(#associated) .. length(#text))
  return mac == tag and chacha20(key, nonce, text) or nil
end
local function xopen(key, nonce, associated, sealed)
  return open(hchacha20(key, nonce:sub(1, 16)), "\0\0\0\0" .. nonce:sub(17, 24), associated, sealed)
end

local keys, group_keys, keys_of = {}, {}, nil
local function from_hex(text) return (text:gsub("%x%x", function(pair) return string.char(tonumber(pair, 16)) end)) end
local function read_keys()
  if keys_of == onemap.prefs.keys then return end
  keys, group_keys, keys_of = {}, {}, onemap.prefs.keys
  local file = keys_of ~= "" and io.open(keys_of)
  if not file then return end
  for line in file:lines() do
    local index, key = line:match("^SESSION (%x+) (%x+)$")
    if index then keys[from_hex(index)] = from_hex(key) end
    local group = line:match("^GROUP (%x+)$")
    if group then group_keys[#group_keys + 1] = from_hex(group) end
  end
  file:close()
end
function onemap.prefs_changed() keys_of = nil end

local function add_robot(tree, range) tree:add(f.robot, range, range:stringz()) end
local function add_log(tree, r, at)
  add_robot(tree, r(at, 16))
  tree:add(f.lane, r(at + 16, 1))
  tree:add_le(f.incarnation, r(at + 17, 8))
end

-- Each: its name, the fewest bytes of its body, and what stands there.
local frames = {
  [1] = { "BEACON", 37, function(t, r)
    add_robot(t, r(0, 16))
    t:add_le(f.frontier, r(16, 8)); t:add_le(f.map, r(24, 8)); t:add_le(f.status, r(32, 4)); t:add(f.flags, r(36, 1))
  end },
  [2] = { "STATUS", 0, function(t, r)
    for at = 0, r:len() - 45, 45 do
      local e = t:add(f.frame, r(at, 45), "entry")
      add_robot(e, r(at, 16))
      e:add_le(f.incarnation, r(at + 16, 8)); e:add_le(f.status, r(at + 24, 4)); e:add_le(f.frontier, r(at + 28, 8))
      e:add_le(f.map, r(at + 36, 8)); e:add(f.flags, r(at + 44, 1))
    end
  end },
  [3] = { "HAVE", 8, function(t, r)
    t:add_le(f.frontier, r(0, 8))
    for at = 8, r:len() - 29, 29 do
      local e = t:add(f.frame, r(at, 29), "entry")
      add_log(e, r, at)
      e:add_le(f.count, r(at + 25, 4))
    end
  end },
  [4] = { "HAVE_REQUEST", 0, function() end },
  [5] = { "WANT", 4, function(t, r)
    t:add_le(f.credit, r(0, 4))
    for at = 4, r:len() - 33, 33 do
      local e = t:add(f.frame, r(at, 33), "entry")
      add_log(e, r, at)
      e:add_le(f.sequence, r(at + 25, 4)); e:add_le(f.fragment, r(at + 29, 2)); e:add_le(f.fragments, r(at + 31, 2))
    end
  end },
  [6] = { "DATA", 46, function(t, r)
    add_log(t, r, 0)
    t:add_le(f.sequence, r(25, 4)); t:add_le(f.kind, r(29, 2)); t:add(f.hops, r(31, 1)); t:add_le(f.size, r(32, 4))
    t:add_le(f.hash, r(36, 8)); t:add_le(f.fragment, r(44, 2))
    if r:len() > 46 then t:add(f.bytes, r(46)) end
  end },
  [7] = { "PING", 4, function(t, r) t:add(f.token, r(0, 4), UInt64(r(0, 4):le_uint())) end },
  [8] = { "PONG", 4, function(t, r) t:add(f.token, r(0, 4), UInt64(r(0, 4):le_uint())) end },
  [10] = { "FEEDBACK", 0, function(t, r) if r:len() > 0 then t:add(f.bytes, r()) end end },
  [128] = { "LATER_LIFE", 24, function(t, r)
    add_robot(t, r(0, 16))
    t:add_le(f.incarnation, r(16, 8))
  end },
}

local function dissect_frames(range, tree, names)
  local at = 0
  while at + 3 <= range:len() do
    local type, size = range(at, 1):uint(), range(at + 1, 2):le_uint()
    local known = frames[type] or { "frame " .. type, 0, function(t, r) if r:len() > 0 then t:add(f.bytes, r()) end end }
    names[#names + 1] = known[1]
    if at + 3 + size > range:len() or size < known[2] then
      tree:add_proto_expert_info(bad_frame)
      return
    end
    local sub = tree:add(f.frame, range(at, 3 + size), known[1])
    if size > 0 then known[3](sub, range(at + 3, size):tvb():range()) end
    at = at + 3 + size
  end
end

local function opened(text, name) return ByteArray.new(text, true):tvb(name):range() end

local function dissect_sealed(buffer, tree, names)
  read_keys()
  tree:add(f.receiver, buffer(4, 4)); tree:add_le(f.counter, buffer(8, 8))
  tree:add(f.sealed, buffer(16, buffer:len() - 32)); tree:add(f.tag, buffer(buffer:len() - 16))
  local key = keys[buffer:raw(4, 4)]
  if not key then return tree:add_proto_expert_info(no_key) end
  local own = buffer(1, 1):uint() == 6
  local nonce = (own and "\1\0\0\0" or "\0\0\0\0") .. buffer:raw(8, 8)
  local text = open(key, nonce, buffer:raw(0, 16), buffer:raw(16))
  if not text then return tree:add_proto_expert_info(bad_tag) end
  if not own then
    if #text > 0 then dissect_frames(opened(text, "Opened"), tree, names) end
    return
  end
  local range = opened(text, "Opened")
  local word = ({ [0] = "here", "probe", "probe answer" })[range(0, 1):uint()] or "unknown"
  tree:add(f.word, range(0, 1), word); tree:add_le(f.token, range(1, 8))
  names[#names + 1] = word
end

local function dissect_group(buffer, tree, names)
  read_keys()
  tree:add(f.nonce, buffer(4, 24)); tree:add(f.sealed, buffer(28, buffer:len() - 44)); tree:add(f.tag, buffer(buffer:len() - 16))
  if #group_keys == 0 then return tree:add_proto_expert_info(no_key) end
  for _, key in ipairs(group_keys) do
    local text = xopen(key, buffer:raw(4, 24), buffer:raw(0, 4), buffer:raw(28))
    if text then
      local range = opened(text, "Opened")
      tree:add_le(f.incarnation, range(0, 8)); tree:add_le(f.counter, range(8, 8))
      if range:len() > 16 then dissect_frames(range(16), tree, names) end
      return
    end
  end
  tree:add_proto_expert_info(bad_tag)
end

local function dissect_handshake(type, buffer, tree)
  if type == 4 then
    tree:add(f.receiver, buffer(4, 4)); tree:add(f.nonce, buffer(8, 24)); tree:add(f.sealed, buffer(32, 32))
    return
  end
  tree:add(f.sender, buffer(4, 4))
  if type == 1 then
    tree:add(f.noise, buffer(8, 48)); tree:add(f.mac1, buffer(56, 16)); tree:add(f.mac2, buffer(72, 16))
    return
  end
  tree:add(f.receiver, buffer(8, 4))
  tree:add(f.noise, buffer(12, buffer:len() - 28)); tree:add(f.mac1, buffer(buffer:len() - 16))
end

local types = { "HELLO", "ANSWER", "PROOF", "COOKIE", "FRAMES", "OWN", [9] = "GROUP" }
local fewest = { 1200, 244, 212, 64, 32, 41, [9] = 60 }

function onemap.dissector(buffer, packet, root)
  if buffer:len() < 4 then return 0 end
  local first, type = buffer(0, 1):uint(), buffer(1, 1):uint()
  local version = band(first, 15)
  if rshift(first, 4) ~= 11 or buffer(2, 2):uint() ~= 0 then return 0 end
  local plain = version == 1 and (type == 8 or type == 9) and buffer:len() >= 24
  if not plain and not (version == 2 and types[type] and buffer:len() >= fewest[type]) then return 0 end
  packet.cols.protocol = "onemap"
  local tree, names = root:add(onemap, buffer()), {}
  tree:add(f.version, buffer(0, 1), version)
  tree:add(f.type, buffer(1, 1))
  local what = plain and "plain" or types[type]
  if plain then
    tree:add_le(f.incarnation, buffer(4, 8)); tree:add_le(f.of_receiver, buffer(12, 8))
    tree:add(f.counter, buffer(20, 4), UInt64(buffer(20, 4):le_uint()))
    if buffer:len() > 24 then dissect_frames(buffer(24), tree, names) end
  elseif type == 9 then
    dissect_group(buffer, tree, names)
  elseif type >= 5 then
    dissect_sealed(buffer, tree, names)
  else
    dissect_handshake(type, buffer, tree)
  end
  packet.cols.info = what .. (#names > 0 and ": " .. table.concat(names, " ") or "")
  tree:append_text(", " .. what)
  return buffer:len()
end

local function guess(buffer, packet, root) return onemap.dissector(buffer, packet, root) > 0 end
onemap:register_heuristic("udp", guess)
DissectorTable.get("udp.port"):add_for_decode_as(onemap)
