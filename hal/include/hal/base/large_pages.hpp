#pragma once
#include <cstddef>

namespace onemap {

// Before memory that is wanted as a whole is first written: the system is asked for large pages, so that it need not be
// asked for each small one. A wish; without it the memory is the same.
void want_large_pages(void* memory, std::size_t bytes);

// The pages that lie whole in this private memory go back to the system; read or written again they are zero, what lies
// on the others stays. False: the system keeps them.
bool give_back_pages(void* memory, std::size_t bytes);

}  // namespace onemap
