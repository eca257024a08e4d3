#include "estimator/factors/solver_log.h"

#include <glog/logging.h>

namespace uniquadric {

void keep_solver_silent() {
  FLAGS_minloglevel = google::GLOG_FATAL;
}

}  // namespace uniquadric
