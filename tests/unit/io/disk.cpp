// SPDX-License-Identifier: MIT
// A disk as tests want it, put before the C library by LD_PRELOAD: full while FULL_DISK is set in the environment, not
// able to reserve room while UNRESERVED is set.
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/statvfs.h>

namespace
{
template <typename... Arguments>
int original(const char* name, Arguments... arguments)
{
  typedef int Function(Arguments...);
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name))(arguments...);
}

template <typename Space>
int look(const char* name, const char* path, Space* out)
{
  const int result = original(name, path, out);
  if (result == 0 && std::getenv("FULL_DISK"))
    out->f_bavail = 0;
  return result;
}

template <typename Offset>
int reserve(const char* name, int file, Offset begin, Offset length)
{
  return std::getenv("UNRESERVED") ? 0 : original(name, file, begin, length);
}
} // namespace

extern "C"
{
  int statvfs(const char* path, struct statvfs* out) noexcept
  {
    return look("statvfs", path, out);
  }
  int posix_fallocate(int file, off_t begin, off_t length)
  {
    return reserve("posix_fallocate", file, begin, length);
  }
#ifdef __GLIBC__ // names that programs call which were compiled for large files
  int statvfs64(const char* path, struct statvfs64* out) noexcept
  {
    return look("statvfs64", path, out);
  }
  int posix_fallocate64(int file, off64_t begin, off64_t length)
  {
    return reserve("posix_fallocate64", file, begin, length);
  }
#endif
}
