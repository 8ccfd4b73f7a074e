// Just enough of a microcontroller's library to run a sketch on this computer: Serial is a pseudo-terminal.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

typedef uint8_t byte;
static int port = -1;

static unsigned long millis() {
  static timespec start{};
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (!start.tv_sec) start = now;
  return (uint32_t)((now.tv_sec - start.tv_sec) * 1000 + (now.tv_nsec - start.tv_nsec) / 1000000);
}

template <class T> static T constrain(T value, T low, T high) { return value < low ? low : value > high ? high : value; }

static char *dtostrf(double value, int width, int digits, char *text) {
  sprintf(text, "%*.*f", width, digits, value);
  return text;
}

struct {
  void begin(long) {}
  int available() {
    int count = 0;
    ioctl(port, FIONREAD, &count);
    return count;
  }
  int read() {
    unsigned char c = 0;
    return ::read(port, &c, 1) == 1 ? c : -1;
  }
  void print(const char *text) {
    if (::write(port, text, strlen(text)) < 0) perror("write");
  }
} Serial;
