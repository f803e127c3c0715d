#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "client/io/file.h"
#include "client/io/geometry.h"
#include "core/base/rng.h"

namespace pliant::io {

/// A folder of its own that goes away with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = testing::TempDir() + "pliant-io-XXXXXX";
    if (mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "cannot create " << name;
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] std::string File(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// Runs a shell command and returns its standard output; fails the test if it fails.
inline std::string Shell(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) {
    ADD_FAILURE() << "cannot run " << command;
    return {};
  }
  std::string output;
  std::array<char, 4096> buffer{};
  std::size_t got = 0;
  while ((got = fread(buffer.data(), 1, buffer.size(), pipe)) > 0)
    output.append(buffer.data(), got);
  const int status = pclose(pipe);
  EXPECT_EQ(status, 0) << command << "\n" << output;
  return output;
}

/// What meshio sees in a file, in the form that meshio_dump.py describes.
inline std::string MeshioDump(const std::string& path) {
  return Shell(std::string(PLIANT_PYTHON) + " " + PLIANT_IO_TESTS + "/meshio_dump.py " + path);
}

/// The mesh in the form of meshio_dump.py: what meshio should see. Coordinates as the bits of
/// the doubles.
inline std::string ExpectedDump(const MeshData& mesh) {
  std::string out;
  std::array<char, 128> line{};
  for (const Vec2 p : mesh.points) {
    snprintf(line.data(), line.size(), "point %016llx %016llx\n",
             std::bit_cast<unsigned long long>(p.x), std::bit_cast<unsigned long long>(p.y));
    out += line.data();
  }
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    snprintf(line.data(), line.size(), "line %d %d tag %d\n", mesh.edges[i][0], mesh.edges[i][1],
             mesh.edge_tags.empty() ? 0 : mesh.edge_tags[i]);
    out += line.data();
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    snprintf(line.data(), line.size(), "triangle %d %d %d tag %d\n", t[0], t[1], t[2],
             mesh.triangle_tags.empty() ? 0 : mesh.triangle_tags[i]);
    out += line.data();
  }
  return out;
}

/// A grid of 2 n^2 triangles whose coordinates have random bits in every digit, with two region
/// tags and four boundary tags.
inline MeshData GridMesh(std::int32_t n, std::uint64_t seed) {
  Rng rng(seed);
  MeshData mesh;
  for (std::int32_t j = 0; j <= n; ++j) {
    for (std::int32_t i = 0; i <= n; ++i) {
      mesh.points.push_back({i + 0.3 * rng.Unit(), (j + 0.3 * rng.Unit()) / 3});
    }
  }
  const auto at = [n](std::int32_t i, std::int32_t j) { return j * (n + 1) + i; };
  for (std::int32_t j = 0; j < n; ++j) {
    for (std::int32_t i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      const std::int32_t tag = i < n / 2 ? 1 : 7;
      mesh.triangle_tags.insert(mesh.triangle_tags.end(), {tag, tag});
    }
  }
  const auto add_edge = [&mesh](std::int32_t a, std::int32_t b, std::int32_t tag) {
    mesh.edges.push_back({a, b});
    mesh.edge_tags.push_back(tag);
  };
  for (std::int32_t i = 0; i < n; ++i) {
    add_edge(at(i, 0), at(i + 1, 0), 1);
    add_edge(at(n, i), at(n, i + 1), 2);
    add_edge(at(i + 1, n), at(i, n), 3);
    add_edge(at(0, i + 1), at(0, i), 40);
  }
  return mesh;
}

/// Feeds `parse` every proper beginning of `bytes` and `flip_count` copies with up to four random
/// bytes changed. The only demand is that it comes back, with a mesh or with an error.
template <class Parse>
void ExpectSurvivesDamage(const std::string& bytes, int flip_count, Parse parse) {
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto result = parse(bytes.substr(0, size));
    EXPECT_TRUE(result.ok() || !result.error().message.empty());
  }
  constexpr std::uint64_t kSeed = 1996;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Rng rng(kSeed);
  for (int trial = 0; trial < flip_count; ++trial) {
    std::string damaged = bytes;
    const std::uint64_t change_count = 1 + rng.Below(4);
    for (std::uint64_t k = 0; k < change_count; ++k) {
      damaged[rng.Below(damaged.size())] = static_cast<char>(rng.Below(256));
    }
    const auto result = parse(damaged);
    EXPECT_TRUE(result.ok() || !result.error().message.empty());
  }
}

}  // namespace pliant::io
