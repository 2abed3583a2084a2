#include "store/confinement.hpp"

#include <seccomp.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <memory>

namespace vrda::store {
namespace {

/// System calls that the C and C++ libraries, zlib and HDF5 need for open files and memory.
constexpr std::initializer_list<int> allowed_calls{
    SCMP_SYS(read),       SCMP_SYS(write),      SCMP_SYS(pread64),       SCMP_SYS(pwrite64),
    SCMP_SYS(lseek),      SCMP_SYS(close),      SCMP_SYS(fstat),         SCMP_SYS(brk),
    SCMP_SYS(munmap),     SCMP_SYS(mremap),     SCMP_SYS(madvise),       SCMP_SYS(futex),
    SCMP_SYS(exit),       SCMP_SYS(exit_group), SCMP_SYS(rt_sigreturn),  SCMP_SYS(rt_sigaction),
    SCMP_SYS(getpid),     SCMP_SYS(gettid),     SCMP_SYS(tgkill),        SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(getrandom),  SCMP_SYS(getrusage),  SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday),
    SCMP_SYS(sched_yield)};

int load_filter(scmp_filter_ctx filter)
{
  for (const int call : allowed_calls)
    if (const int error = seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0); error != 0) return error;
  // Memory, but not executable memory.
  for (const int call : {SCMP_SYS(mmap), SCMP_SYS(mprotect)}) {
    const int error =
        seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 1, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
    if (error != 0) return error;
  }
  return seccomp_load(filter);  // sets no_new_privs too
}

}  // namespace

std::string confine_this_process()
{
  if (is_sanitized) return {};
  const std::unique_ptr<void, decltype(&seccomp_release)> filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)),
                                                                 &seccomp_release);
  const int error = filter ? load_filter(filter.get()) : -ENOMEM;
  return error == 0 ? "" : std::strerror(-error);
}

}  // namespace vrda::store
