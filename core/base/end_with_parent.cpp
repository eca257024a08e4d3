#include "core/base/end_with_parent.h"

#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

namespace uniquadric {

void end_with_parent(int parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
}

}  // namespace uniquadric
