#include <pliant/client/cpp/client.h>

#include <iostream>

// There is no server here: what counts is that a program links and gets the precise error.
int main() {
  pliant::client::ConnectOptions options;
  options.connect_timeout = std::chrono::milliseconds(200);
  const auto client = pliant::client::Client::Connect("unix:no_server_here.sock", options);
  if (client.ok()) return 1;
  std::cout << client.error().message << "\n";
  return client.error().code == pliant::ErrorCode::kUnavailable ? 0 : 1;
}
