// What the programs of this folder share: the npm module canopen, and a CAN channel for it.
const { createRequire } = require("node:module");
const { resolve } = require("node:path");
const net = require("node:net");

/** The CRC of block transfers: polynomial 1021h, initial value 0 (CiA 301 7.2.4.3.16). */
function crc16(data) {
  let crc = 0;
  for (const byte of data) {
    crc ^= byte << 8;
    for (let bit = 0; bit < 8; bit++) crc = (crc & 0x8000 ? (crc << 1) ^ 0x1021 : crc << 1) & 0xffff;
  }
  return crc;
}

/** The module canopen of `folder`/node_modules. */
function loadCanopen(folder) {
  const load = createRequire(resolve(folder, "package.json"));
  // npm ci --ignore-scripts does not build the native module that the module computes this CRC with.
  const native = load.resolve("node-crc");
  require.cache[native] = {
    id: native, filename: native, loaded: true,
    exports: {
      crc: (_bits, _reflect, _polynomial, _initial, ...rest) => {
        const result = Buffer.alloc(2);
        result.writeUInt16BE(crc16(rest.at(-1)));
        return result;
      },
    },
  };
  return load("canopen");
}

/** A CAN channel as the module expects one, on a serial CAN adapter over TCP. */
class SlcanChannel {
  constructor(onMessage) {
    this.onMessage = onMessage;
    this.refused = 0;
    this.text = "";
  }

  async start(to) {
    this.socket = net.createConnection({ port: to, host: "127.0.0.1", noDelay: true });
    await new Promise((done, fail) => this.socket.once("connect", done).once("error", fail));
    this.socket.on("data", (bytes) => this.receive(bytes.toString("latin1")));
    this.socket.write("C\rS8\rO\r");
  }

  stop() {
    this.socket.end("C\r");
  }

  send({ id, data }) {
    const content = Buffer.from(data);
    this.socket.write(`t${id.toString(16).padStart(3, "0")}${content.length}${content.toString("hex")}\r`);
  }

  receive(text) {
    this.text += text;
    for (let end; (end = this.text.search(/[\r\x07]/)) >= 0; this.text = this.text.slice(end + 1)) {
      const line = this.text.slice(0, end);
      // The answer to the first C: the channel was closed anyway.
      if (this.text[end] === "\x07") this.refused++;
      if (line[0] !== "t") continue;
      const length = Number(line[4]);
      this.onMessage({ id: parseInt(line.slice(1, 4), 16), data: Buffer.from(line.slice(5, 5 + 2 * length), "hex") });
    }
  }
}

module.exports = { SlcanChannel, loadCanopen };
