// SPDX-License-Identifier: MIT
#include "lanes.h"
#include <new>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace dolfinx_impact::operators
{
namespace
{
constexpr std::size_t large_page = std::size_t(1) << 21; ///< [bytes]; larger ones of other machines are left alone

/// Arrays that hold two large pages or more begin with one; what is left behind their last one lies in small pages.
std::align_val_t alignment_of(std::size_t bytes)
{
  return std::align_val_t{bytes >= 2 * large_page ? large_page : alignment};
}
} // namespace

void* allocate_lines(std::size_t bytes)
{
  void* p = ::operator new(bytes, alignment_of(bytes));
#if defined(MADV_HUGEPAGE)
  // A hint: a system without large pages refuses it, and pages stay as they are.
  if (bytes >= 2 * large_page)
    madvise(p, bytes / large_page * large_page, MADV_HUGEPAGE);
#endif
  return p;
}

void free_lines(void* p, std::size_t bytes)
{
  ::operator delete(p, alignment_of(bytes));
}
} // namespace dolfinx_impact::operators
