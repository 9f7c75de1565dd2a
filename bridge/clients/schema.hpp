#pragma once

#include <cstdint>
#include <span>
#include <string_view>

/// Topics and their types as driveline-dds knows them; make_topics.py generates the tables from the IDL.
namespace driveline::bridge::clients {

/// Kind of a field, or of the elements of a sequence.
enum class Kind : std::uint8_t {
  kBool,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble,
  kString,
  kEnum,
  kStruct,
};

/// An enumeration; 32 bits on the wire.
struct EnumType {
  std::span<const std::string_view> names;  ///< by value
};

struct StructType;

/// A field of a structure.
struct Field {
  std::string_view name;
  Kind kind;
  bool sequence;                ///< a sequence of `kind`
  std::uint32_t count;          ///< number of elements of an array; 0: not an array
  bool key;                     ///< part of the key that distinguishes instances of the topic
  const EnumType* enumeration;  ///< kEnum only
  const StructType* structure;  ///< kStruct only
};

/// A structure.
struct StructType {
  std::string_view name;  ///< name in ROS 2, e.g. "driveline/Event"
  std::span<const Field> fields;
};

/// A topic, how to read it, how to count its samples and how to convert them to rows. Names of fields are empty if
/// there is no such field.
struct Topic {
  std::string_view name;    ///< e.g. "driveline/v1/event"
  std::string_view type;    ///< type name on the wire, e.g. "driveline::telemetry::Event"
  std::string_view schema;  ///< type name in a recording, e.g. "driveline/msg/Event"
  std::string_view text;    ///< type definition in a recording (ros2msg)
  const StructType* structure;
  bool reliable;                   ///< the writer repeats lost samples for readers that request it
  bool kept;                       ///< the writer stores samples for late subscribers
  std::string_view counter;        ///< field that counts samples
  std::string_view counter_of;     ///< field that identifies the counter
  std::string_view rows;           ///< sequence whose elements are the rows of a table
  std::string_view partner_index;  ///< field of a row element: index into `partners`
  std::string_view partners;       ///< sequence whose elements belong to rows
};

/// All topics, in the order of the documentation.
[[nodiscard]] std::span<const Topic> topics() noexcept;
/// Finds the topic called `name`; null if there is none.
[[nodiscard]] const Topic* find_topic(std::string_view name) noexcept;

}  // namespace driveline::bridge::clients
