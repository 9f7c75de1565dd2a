// read_recording.mjs FILE FOLDER: reads a recording with @mcap/core, once from front to back with every checksum, once by its
// index, and decodes each sample with the libraries by which Foxglove decodes it, which FOLDER/node_modules has. Prints
// what it found as JSON, one line for each sample behind a line for the file.
import { createRequire } from "node:module";
import { open } from "node:fs/promises";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";

const [, , file, folder] = process.argv;
const require = createRequire(resolve(folder, "package.json"));
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const plain = (_key, value) => {
  if (typeof value === "bigint") return value.toString();
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
};

// From front to back.
const records = {};
const stream = new McapStreamReader({ validateCrcs: true });
stream.append(readFileSync(file));
for (let record; (record = stream.nextRecord()) !== undefined; ) {
  records[record.type] = (records[record.type] ?? 0) + 1;
}
const complete = stream.done() && stream.bytesRemaining() === 0;

// By the index.
const handle = await open(file, "r");
const { size } = await handle.stat();
const readable = {
  size: async () => BigInt(size),
  read: async (offset, length) => {
    const buffer = new Uint8Array(Number(length));
    const { bytesRead } = await handle.read(buffer, 0, buffer.length, Number(offset));
    if (bytesRead !== buffer.length) throw new Error("read beyond the end");
    return buffer;
  },
};
const reader = await McapIndexedReader.Initialize({ readable });
const decoders = new Map();
for (const channel of reader.channelsById.values()) {
  const schema = reader.schemasById.get(channel.schemaId);
  if (schema.encoding !== "ros2msg" || channel.messageEncoding !== "cdr") throw new Error(`${channel.topic}: another encoding`);
  decoders.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
}
const counts = Object.fromEntries([...reader.statistics.channelMessageCounts].map(([id, count]) => [reader.channelsById.get(id).topic, Number(count)]));
const types = Object.fromEntries([...reader.channelsById.values()].map((channel) => [channel.topic, reader.schemasById.get(channel.schemaId).name]));
const qos = Object.fromEntries([...reader.channelsById.values()].map((channel) => [channel.topic, channel.metadata.get("offered_qos_profiles")]));
const { library, profile } = reader.header;
console.log(JSON.stringify({ records, complete, counts, types, qos, library, profile, chunks: reader.chunkIndexes.length }));
for await (const message of reader.readMessages()) {
  const { topic } = reader.channelsById.get(message.channelId);
  const sample = decoders.get(message.channelId).readMessage(message.data);
  console.log(JSON.stringify({ topic, sequence: message.sequence, log: message.logTime, publish: message.publishTime, sample }, plain));
}
await handle.close();
