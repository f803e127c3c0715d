#include "client/io/gmsh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "client/io/gmsh_elements.h"
#include "client/io/number_reader.h"

namespace pliant::io {
namespace {

/// A node, line or triangle with the node numbers of the file.
struct Node {
  std::int64_t number = 0;
  Vec2 point;
  double z = 0;
};
template <std::size_t kCorners>
struct Element {
  std::array<std::int64_t, kCorners> nodes;
  std::int32_t tag = 0;
};
struct EntityTag {
  std::int64_t dimension = 0;
  std::int64_t entity = 0;
  std::int32_t tag = 0;
};

bool Before(const EntityTag& a, const EntityTag& b) {
  return a.dimension != b.dimension ? a.dimension < b.dimension : a.entity < b.entity;
}

class GmshParser {
 public:
  explicit GmshParser(std::string_view bytes) : reader_(bytes) {}
  Result<GmshGeometry> Parse();

 private:
  void ReadFormat();
  void ReadSection(std::string_view name);
  void ReadEntities();
  void ReadEntity(std::int64_t dimension);
  void ReadNodes2();
  void ReadNodes4();
  void ReadElements2();
  void ReadElements4();
  void ReadElement(std::int64_t type, std::int32_t tag);
  [[nodiscard]] std::int64_t CornerCount(std::int64_t type);
  [[nodiscard]] std::int32_t PhysicalTag(std::int64_t dimension, std::int64_t entity) const;
  /// Each number takes two bytes of text or more, and four of binary or more.
  [[nodiscard]] std::size_t Count(std::int64_t count, std::size_t numbers_per_element) {
    return reader_.Count(count, numbers_per_element * (binary_ ? 4 : 2));
  }
  void UseBinaryIfFileIs() {
    if (!binary_) return;
    reader_.SkipLine();
    reader_.set_encoding(encoding_);
  }

  NumberReader reader_;
  bool binary_ = false;
  NumberReader::Encoding encoding_ = NumberReader::Encoding::kText;
  std::int64_t version_ = 0;  ///< 2 or 4; 0 before the section that says so.
  std::vector<EntityTag> entity_tags_;
  std::vector<Node> nodes_;
  std::vector<Element<2>> lines_;
  std::vector<Element<3>> triangles_;
};

/// Finds points by the numbers that the file gives to nodes.
class NodeIndex {
 public:
  explicit NodeIndex(const std::vector<Node>& nodes);
  [[nodiscard]] Status status() const { return status_; }
  /// The node's place in the file; -1 if there is none with that number.
  [[nodiscard]] std::int64_t Find(std::int64_t number) const;

 private:
  std::vector<std::pair<std::int64_t, std::int64_t>> places_;  ///< (number, place), sorted.
  Status status_;
};

NodeIndex::NodeIndex(const std::vector<Node>& nodes) {
  places_.reserve(nodes.size());
  bool is_sorted = true;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    is_sorted = is_sorted && (i == 0 || nodes[i - 1].number < nodes[i].number);
    places_.emplace_back(nodes[i].number, static_cast<std::int64_t>(i));
  }
  if (!is_sorted) std::sort(places_.begin(), places_.end());
  for (std::size_t i = 1; i < places_.size(); ++i) {
    if (places_[i - 1].first != places_[i].first) continue;
    status_ = Error{.code = ErrorCode::kDuplicateId,
                    .message = "two nodes have the number " + std::to_string(places_[i].first),
                    .field = "nodes",
                    .index = places_[i - 1].second,
                    .other_index = places_[i].second};
    return;
  }
}

std::int64_t NodeIndex::Find(std::int64_t number) const {
  if (places_.empty()) return -1;
  // Most files count without gaps; then the place is known at once.
  if (number < places_.front().first) return -1;
  const std::uint64_t offset =
      static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(places_.front().first);
  if (offset < places_.size() && places_[offset].first == number) return places_[offset].second;
  const auto found =
      std::lower_bound(places_.begin(), places_.end(), std::pair(number, std::int64_t{-1}));
  return found != places_.end() && found->first == number ? found->second : -1;
}

/// Gives points that are used a dense number in the order of the file, and drops the others.
class Compactor {
 public:
  Compactor(const std::vector<Node>& nodes, const NodeIndex& index)
      : nodes_(nodes), index_(index), point_of_place_(nodes.size(), -1) {}

  template <std::size_t kCorners>
  Status Mark(const std::vector<Element<kCorners>>& elements, const char* field) {
    for (std::size_t i = 0; i < elements.size(); ++i) {
      for (const std::int64_t number : elements[i].nodes) {
        const std::int64_t place = index_.Find(number);
        if (place < 0) {
          return Error{.code = ErrorCode::kIndexOutOfRange,
                       .message = std::string("element ") + std::to_string(i) + " of the " + field +
                                  " (counted from 0) names node " + std::to_string(number) +
                                  ", which the file does not have",
                       .field = field,
                       .index = static_cast<std::int64_t>(i)};
        }
        point_of_place_[static_cast<std::size_t>(place)] = 0;
      }
    }
    return {};
  }

  Status Number(MeshData& mesh, std::vector<std::int64_t>& node_numbers);

  template <std::size_t kCorners>
  void Translate(const std::vector<Element<kCorners>>& elements,
                 std::vector<std::array<std::int32_t, kCorners>>& out,
                 std::vector<std::int32_t>& tags) const {
    out.reserve(elements.size());
    tags.reserve(elements.size());
    for (const Element<kCorners>& element : elements) {
      std::array<std::int32_t, kCorners> points{};
      for (std::size_t k = 0; k < kCorners; ++k) {
        points[k] = point_of_place_[static_cast<std::size_t>(index_.Find(element.nodes[k]))];
      }
      out.push_back(points);
      tags.push_back(element.tag);
    }
  }

 private:
  const std::vector<Node>& nodes_;
  const NodeIndex& index_;
  std::vector<std::int32_t> point_of_place_;
};

Status Compactor::Number(MeshData& mesh, std::vector<std::int64_t>& node_numbers) {
  double plane = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (point_of_place_[i] < 0) continue;
    if (mesh.points.empty()) plane = nodes_[i].z;
    if (nodes_[i].z != plane) {
      return Error{.code = ErrorCode::kFileUnsupported,
                   .message = "node " + std::to_string(nodes_[i].number) +
                              " does not lie in the plane z = constant of the others; only plane "
                              "meshes are read",
                   .field = "nodes",
                   .index = static_cast<std::int64_t>(i)};
    }
    point_of_place_[i] = static_cast<std::int32_t>(mesh.points.size());
    mesh.points.push_back(nodes_[i].point);
    node_numbers.push_back(nodes_[i].number);
  }
  return {};
}

Result<GmshGeometry> GmshParser::Parse() {
  ReadFormat();
  while (reader_.ok() && !reader_.AtEnd()) {
    const std::string_view word = reader_.Word();
    if (!word.starts_with('$')) {
      reader_.FailSyntax("expected a section such as '$Nodes'");
      break;
    }
    ReadSection(word.substr(1));
  }
  PLIANT_RETURN_IF_ERROR(reader_.status());
  constexpr auto kCountMax = std::size_t{std::numeric_limits<std::int32_t>::max()};
  if (std::max({nodes_.size(), lines_.size(), triangles_.size()}) > kCountMax) {
    return Error{.code = ErrorCode::kTooLarge, .message = "more than 2147483647 nodes or elements"};
  }
  if (lines_.empty() && triangles_.empty()) {
    return Error{.code = ErrorCode::kEmpty,
                 .message =
                     "the file has neither triangles nor lines; mesh the model first, or "
                     "put its surfaces and curves into physical groups"};
  }
  const NodeIndex index(nodes_);
  PLIANT_RETURN_IF_ERROR(index.status());
  Compactor compactor(nodes_, index);
  PLIANT_RETURN_IF_ERROR(compactor.Mark(triangles_, "triangles"));
  PLIANT_RETURN_IF_ERROR(compactor.Mark(lines_, "edges"));
  MeshData mesh;
  GmshGeometry result;
  PLIANT_RETURN_IF_ERROR(compactor.Number(mesh, result.node_numbers));
  compactor.Translate(triangles_, mesh.triangles, mesh.triangle_tags);
  compactor.Translate(lines_, mesh.edges, mesh.edge_tags);
  result.geometry = GeometryFromMesh(std::move(mesh));
  return result;
}

void GmshParser::ReadFormat() {
  reader_.Expect("$MeshFormat");
  const std::string_view version = reader_.Word();
  const std::int64_t kind = reader_.Integer();
  const std::int64_t real_size = reader_.Integer();
  if (!reader_.ok()) return;
  if (version != "2.2" && version != "2" && version != "4.1") {
    return reader_.Fail(ErrorCode::kFileUnsupported,
                        "Gmsh format " + std::string(version.substr(0, 16)) +
                            " is not read, only 2.2 and 4.1; convert it with "
                            "'gmsh FILE.msh -save -format msh41 -o NEW.msh'");
  }
  if (kind < 0 || kind > 1 || real_size != 8) {
    return reader_.Fail(ErrorCode::kFileUnsupported,
                        "expected '0 8' (text) or '1 8' (binary) after the version; convert it "
                        "with 'gmsh FILE.msh -save -format msh41 -o NEW.msh'");
  }
  version_ = version == "4.1" ? 4 : 2;
  if (kind == 1) {
    binary_ = true;
    reader_.SkipLine();
    reader_.set_encoding(NumberReader::Encoding::kBinary);
    encoding_ = reader_.Short() == 1 ? NumberReader::Encoding::kBinary
                                     : NumberReader::Encoding::kBinarySwapped;
    reader_.set_encoding(NumberReader::Encoding::kText);
  }
  reader_.SkipPast("$EndMeshFormat");
}

void GmshParser::ReadSection(std::string_view name) {
  if (name == "Entities") {
    ReadEntities();
  } else if (name == "Nodes") {
    version_ == 2 ? ReadNodes2() : ReadNodes4();
  } else if (name == "Elements") {
    version_ == 2 ? ReadElements2() : ReadElements4();
  } else if (name == "PartitionedEntities") {
    reader_.Fail(ErrorCode::kFileUnsupported,
                 "the mesh is partitioned; save it without partitions (gmsh -part 0)");
  }
  reader_.set_encoding(NumberReader::Encoding::kText);
  reader_.SkipPast("$End" + std::string(name));
}

void GmshParser::ReadEntities() {
  UseBinaryIfFileIs();
  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = Count(reader_.Long(), 5);
  for (std::size_t dimension = 0; dimension < 3; ++dimension) {
    for (std::size_t i = 0; i < counts[dimension] && reader_.ok(); ++i) {
      ReadEntity(static_cast<std::int64_t>(dimension));
    }
  }
  // Volumes follow, which carry nothing that is kept.
  std::sort(entity_tags_.begin(), entity_tags_.end(), Before);
}

void GmshParser::ReadEntity(std::int64_t dimension) {
  const std::int64_t entity = reader_.Short();
  const int coordinate_count = dimension == 0 ? 3 : 6;
  for (int k = 0; k < coordinate_count; ++k) reader_.Real();
  const std::size_t physical_count = Count(reader_.Long(), 1);
  for (std::size_t k = 0; k < physical_count && reader_.ok(); ++k) {
    const std::int64_t tag = reader_.Short();
    if (tag < std::numeric_limits<std::int32_t>::min() ||
        tag > std::numeric_limits<std::int32_t>::max()) {
      return reader_.Fail(ErrorCode::kOutOfRange, "a physical tag does not fit 32 bits");
    }
    if (k > 0) continue;
    entity_tags_.push_back(
        {.dimension = dimension, .entity = entity, .tag = static_cast<std::int32_t>(tag)});
  }
  if (dimension == 0) return;
  const std::size_t bounding_count = Count(reader_.Long(), 1);
  for (std::size_t k = 0; k < bounding_count && reader_.ok(); ++k) reader_.Short();
}

void GmshParser::ReadNodes2() {
  // The count is text in binary files too.
  const std::size_t count = Count(reader_.Integer(), 4);
  UseBinaryIfFileIs();
  nodes_.resize(count);
  for (std::size_t i = 0; i < count && reader_.ok(); ++i) {
    nodes_[i].number = reader_.Short();
    nodes_[i].point.x = reader_.Real();
    nodes_[i].point.y = reader_.Real();
    nodes_[i].z = reader_.Real();
  }
}

void GmshParser::ReadNodes4() {
  UseBinaryIfFileIs();
  const std::size_t block_count = Count(reader_.Long(), 4);
  for (int k = 0; k < 3; ++k) reader_.Long();
  for (std::size_t b = 0; b < block_count && reader_.ok(); ++b) {
    const std::int64_t dimension = reader_.Short();
    reader_.Short();
    const bool is_parametric = reader_.Short() != 0;
    const std::int64_t parameter_count =
        is_parametric ? std::clamp<std::int64_t>(dimension, 0, 3) : 0;
    const std::size_t count = Count(reader_.Long(), 4);
    const std::size_t begin = nodes_.size();
    nodes_.resize(begin + count);
    for (std::size_t i = 0; i < count; ++i) nodes_[begin + i].number = reader_.Long();
    for (std::size_t i = 0; i < count && reader_.ok(); ++i) {
      Node& node = nodes_[begin + i];
      node.point.x = reader_.Real();
      node.point.y = reader_.Real();
      node.z = reader_.Real();
      for (std::int64_t k = 0; k < parameter_count; ++k) reader_.Real();
    }
  }
}

void GmshParser::ReadElements2() {
  const std::size_t count = Count(reader_.Integer(), 4);
  UseBinaryIfFileIs();
  std::size_t i = 0;
  while (i < count && reader_.ok()) {
    // In text each element has a header of its own, and its number comes first.
    if (!binary_) reader_.Integer();
    const std::int64_t type = reader_.Integer();
    const std::size_t block_size = binary_ ? Count(reader_.Integer(), 2) : 1;
    const std::size_t tag_count = Count(reader_.Integer(), 1);
    if (reader_.ok() && block_size == 0) reader_.FailSyntax("an empty block of elements");
    for (std::size_t k = 0; k < block_size && reader_.ok(); ++k, ++i) {
      if (binary_) reader_.Integer();
      std::int32_t physical = 0;
      for (std::size_t t = 0; t < tag_count && reader_.ok(); ++t) {
        const std::int32_t tag = reader_.Tag();
        if (t == 0) physical = tag;
      }
      ReadElement(type, physical);
    }
  }
}

void GmshParser::ReadElements4() {
  UseBinaryIfFileIs();
  const std::size_t block_count = Count(reader_.Long(), 4);
  for (int k = 0; k < 3; ++k) reader_.Long();
  for (std::size_t b = 0; b < block_count && reader_.ok(); ++b) {
    const std::int64_t dimension = reader_.Short();
    const std::int64_t entity = reader_.Short();
    const std::int64_t type = reader_.Short();
    const std::size_t count = Count(reader_.Long(), 2);
    const std::int32_t tag = PhysicalTag(dimension, entity);
    for (std::size_t i = 0; i < count && reader_.ok(); ++i) {
      reader_.Long();
      ReadElement(type, tag);
    }
  }
}

void GmshParser::ReadElement(std::int64_t type, std::int32_t tag) {
  const std::int64_t corner_count = CornerCount(type);
  std::array<std::int64_t, 3> nodes{};
  for (std::int64_t k = 0; k < corner_count; ++k) {
    nodes[static_cast<std::size_t>(k)] = version_ == 2 ? reader_.Integer() : reader_.Long();
  }
  if (!reader_.ok()) return;
  if (type == kGmshLine) lines_.push_back({.nodes = {nodes[0], nodes[1]}, .tag = tag});
  if (type == kGmshTriangle) triangles_.push_back({.nodes = nodes, .tag = tag});
}

std::int64_t GmshParser::CornerCount(std::int64_t type) {
  if (!reader_.ok()) return 0;
  if (type == kGmshPoint) return 1;
  if (type == kGmshLine) return 2;
  if (type == kGmshTriangle) return 3;
  reader_.Fail(ErrorCode::kFileUnsupported,
               "element type " + std::to_string(type) +
                   " is neither a line nor a triangle with straight edges; mesh in two dimensions, "
                   "with order 1 and without recombination (gmsh -2 -order 1)");
  return 0;
}

std::int32_t GmshParser::PhysicalTag(std::int64_t dimension, std::int64_t entity) const {
  const EntityTag wanted{.dimension = dimension, .entity = entity, .tag = 0};
  const auto found = std::lower_bound(entity_tags_.begin(), entity_tags_.end(), wanted, Before);
  return found != entity_tags_.end() && !Before(wanted, *found) ? found->tag : 0;
}

}  // namespace

Result<GmshGeometry> ParseGmsh(std::string_view bytes) { return GmshParser(bytes).Parse(); }

}  // namespace pliant::io
