#include "process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>

#include "sanitizers.h"

namespace mass_spring {
namespace {

constexpr std::chrono::seconds kDeadline{60};
constexpr int kPollMilliseconds = 10;

[[noreturn]] void become(const std::vector<std::string>& arguments, int out, int err) {
  if (!underSanitizers()) {  // they reserve terabytes of addresses
    const rlimit limit{2ull << 30, 2ull << 30};
    setrlimit(RLIMIT_AS, &limit);
  }
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(argv[0], argv.data());
  _exit(127);
}

/// Appends what a pipe has ready; false at its end.
bool drain(int pipe, std::string& text) {
  char bytes[4096];
  const ssize_t count = ::read(pipe, bytes, sizeof bytes);
  if (count > 0) text.append(bytes, static_cast<std::size_t>(count));
  return count > 0;
}

}  // namespace

std::string programPath(const std::string& name) {
  const char* folder = std::getenv("MASS_SPRING_PROGRAM_FOLDER");
  return std::string(folder ? folder : MASS_SPRING_PROGRAM_FOLDER) + "/" + name;
}

ProcessResult runProcess(const std::vector<std::string>& arguments,
                         const std::function<void(int)>& while_running) {
  int out[2], err[2];
  if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) return {};
  if (underSanitizers()) unsetenv("LD_PRELOAD");  // a program with sanitizers brings them along
  const pid_t child = fork();
  if (child == 0) become(arguments, out[1], err[1]);
  close(out[1]);
  close(err[1]);

  ProcessResult result;
  const auto deadline = std::chrono::steady_clock::now() + kDeadline;
  pollfd pipes[] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  std::string* const texts[] = {&result.out, &result.err};
  bool late = false;
  while (!late && (pipes[0].fd >= 0 || pipes[1].fd >= 0)) {
    poll(pipes, 2, kPollMilliseconds);
    for (int i = 0; i < 2; ++i) {
      const bool ready = pipes[i].fd >= 0 && pipes[i].revents != 0;
      if (ready && !drain(pipes[i].fd, *texts[i])) pipes[i].fd = -1;  // poll() skips it
    }
    if (while_running) while_running(child);
    late = std::chrono::steady_clock::now() > deadline;
  }
  if (late) kill(child, SIGKILL);
  close(out[0]);
  close(err[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (late) return result;
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace mass_spring
