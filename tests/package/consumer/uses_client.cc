#include <pliant/client/cpp/client.h>

#include <iostream>

// No server listens there: what is tried is that the client compiles and links with all it needs.
int main() {
  pliant::client::ConnectOptions options;
  options.connect_timeout = std::chrono::milliseconds(200);
  const auto client = pliant::client::Client::Connect("unix:no_such.sock", options);
  if (client.ok()) return 1;
  std::cout << client.error().message << "\n";
  return client.error().code == pliant::ErrorCode::kUnavailable ? 0 : 1;
}
