#include "core/transfer/saved_fields.h"

#include <utility>

#include "core/transfer/field_set.h"

namespace pliant {

SharedFields KeepFields(std::span<const Field> fields) {
  if (fields.empty()) return nullptr;
  return std::make_shared<const std::vector<Field>>(fields.begin(), fields.end());
}

std::size_t BytesOf(const SharedFields& fields) {
  std::size_t bytes = 0;
  if (fields == nullptr) return bytes;
  for (const Field& field : *fields) bytes += sizeof(Field) + field.values.size() * sizeof(double);
  return bytes;
}

void WriteFields(const SharedFields& fields, ByteWriter& writer) {
  const std::span<const Field> all = fields ? std::span(*fields) : std::span<const Field>();
  writer.Put(static_cast<std::uint32_t>(all.size()));
  for (const Field& field : all) {
    writer.PutText(field.name);
    writer.Put(static_cast<std::uint8_t>(field.location));
    writer.Put(static_cast<std::uint8_t>(field.transfer));
    writer.Put(static_cast<std::uint8_t>(field.column_count));
    writer.PutColumn(field.values);
  }
}

SharedFields ReadFields(ByteReader& reader, std::int32_t vertex_slots,
                        std::int32_t triangle_slots) {
  const auto count = reader.Take<std::uint32_t>();
  if (count > FieldSet::kFieldsMax) reader.Fail();
  std::vector<Field> fields;
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    Field field;
    field.name = reader.TakeText();
    const auto location = reader.Take<std::uint8_t>();
    const auto transfer = reader.Take<std::uint8_t>();
    field.column_count = reader.Take<std::uint8_t>();
    field.values = reader.TakeColumn<double>();
    if (location > static_cast<std::uint8_t>(FieldLocation::kTriangle) ||
        transfer > static_cast<std::uint8_t>(TransferKind::kConservative)) {
      reader.Fail();
    }
    field.location = static_cast<FieldLocation>(location);
    field.transfer = static_cast<TransferKind>(transfer);
    const std::int32_t slots =
        field.location == FieldLocation::kVertex ? vertex_slots : triangle_slots;
    if (field.column_count < 1 || field.column_count > 3 ||
        field.values.size() != static_cast<std::size_t>(slots) * field.column_count ||
        (!fields.empty() && field.name <= fields.back().name)) {
      reader.Fail();
    }
    fields.push_back(std::move(field));
  }
  return reader.ok() ? KeepFields(fields) : nullptr;
}

}  // namespace pliant
