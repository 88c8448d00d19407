#pragma once

#include <string>

#include "tools/study_run.h"

namespace mass_spring {

/// A pendulum on a spring: 22 rad/s along it, 7 rad/s across.
extern const char* const kPendulum;
/// A bob that bounces on a damped spring below a pin: linear, and every scheme's answer is known.
extern const char* const kBouncing;

/// A study of a scene whose frames come at its rate, without a program around it.
Study studyOf(const Scene& scene, double duration);
Study studyOf(const std::string& scene, double duration);

}  // namespace mass_spring
