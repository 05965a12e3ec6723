#pragma once
#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

namespace onemap::hal::imaging {

// How libjpeg's errors come back. It hands its callbacks the first member. Plain data: a longjmp passes over it.
struct JpegState {
  jpeg_error_mgr manager;
  std::jmp_buf jump;
  char reason[JMSG_LENGTH_MAX];
};

[[noreturn]] inline void on_jpeg_error(j_common_ptr jpeg) {
  auto* state = reinterpret_cast<JpegState*>(jpeg->err);
  jpeg->err->format_message(jpeg, state->reason);
  std::longjmp(state->jump, 1);
}

}  // namespace onemap::hal::imaging
