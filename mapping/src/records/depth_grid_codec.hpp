#pragma once
#include "mapping/records/depth_grid.hpp"
#include "records/field_reader.hpp"

namespace onemap::mapping {

// The depth grid at the end of a record: width, height and pinhole, then, unless it has no cells, one zstd frame with
//   a mask of the cells that have a depth (a bit a cell, zeros beyond the last),
//   for these cells in order the low bytes, then the high bytes of the zigzagged difference to what the neighbours
//   above and to the left let expect (median edge detector; Weinberger, Seroussi, Sapiro 2000: LOCO-I).
// What decoding costs is known before anything is decompressed: two bytes and a bit a cell at most, from a frame that
// is no longer than that much content can need. What is canonical is the content of the frame, as in submaps.
void put(ByteWriter& out, const DepthGrid& grid);
DepthGrid read_grid_head(FieldReader& in);                // without its depths
void read_grid_depths(FieldReader& in, DepthGrid& grid);  // what remains of the record

}  // namespace onemap::mapping
