// master.cjs PORT FOLDER SHEET NODE: the npm module canopen, which FOLDER/node_modules has, as the master of a served CAN line:
// SDO, NMT, heartbeat, SYNC, PDO and EMCY with the node NODE, whose electronic data sheet is SHEET. The module sends and
// receives by the slcan door at 127.0.0.1:PORT. Prints what it has seen as one JSON document.
const { SlcanChannel, loadCanopen } = require("./slcan.cjs");

const [, , port, folder, sheet, nodeText] = process.argv;
const NODE = Number(nodeText);

const { Device, DataType, Eds, SdoError, calculateCrc } = loadCanopen(folder);

const PATIENCE_MS = 60_000;
const MASTER = 100; // its own node-ID
const STATUS = 0x5000, POSITION = 0x5001, CONTROL = 0x5002, TARGET = 0x5003; // in its own dictionary

async function until(what, holds) {
  const deadline = Date.now() + PATIENCE_MS;
  while (!holds()) {
    if (Date.now() > deadline) throw new Error(`never came: ${what}`);
    await new Promise((done) => setTimeout(done, 1));
  }
}

/** A value of a sheet: a number, or one that counts from the node-ID; null: anything else, or nothing. */
function numberOf(text) {
  const words = String(text ?? "").trim();
  const counted = /^\$NODEID\s*\+\s*(\w+)$/i.exec(words);
  const number = Number(counted ? counted[1] : words);
  return words === "" || Number.isNaN(number) ? null : number + (counted ? NODE : 0);
}

class Master {
  constructor(eds) {
    this.eds = eds;
    this.heartbeats = [];
    this.emergencies = [];
    this.syncs = 0;
    this.device = new Device({ id: MASTER });
    this.channel = new SlcanChannel((message) => this.device.receive(message));
    this.device.addListener("message", (message) => {
      if (message.id === 0x80) this.syncs++;
      this.channel.send(message);
    });
    this.device.nmt.addListener("heartbeat", ({ state }) => this.heartbeats.push(state));
    this.device.nmt.addListener("timeout", () => this.heartbeats.push("lost"));
    this.device.emcy.addListener("emergency", ({ em }) =>
      this.emergencies.push([em.code, em.register, Buffer.from(em.info).toString("hex")]));
    this.configure();
  }

  cobId(index, subIndex) {
    const object = this.eds.getEntry(index);
    return numberOf((subIndex === undefined ? object : object.at(subIndex)).defaultValue);
  }

  configure() {
    const own = this.device.eds;
    own.addSdoClientParameter(NODE, 0x600 + NODE, 0x580 + NODE);
    own.addEmcyConsumer(this.cobId(0x1014));
    own.addHeartbeatConsumer(NODE, 500);
    own.setSyncCobId(this.cobId(0x1005));
    own.setSyncGenerationEnable(true);
    const entry = (index, parameterName, dataType) => own.addEntry(index, { parameterName, dataType });
    const status = entry(STATUS, "status word", DataType.UNSIGNED16);
    const position = entry(POSITION, "position", DataType.INTEGER32);
    const control = entry(CONTROL, "control word", DataType.UNSIGNED16);
    const target = entry(TARGET, "target position", DataType.INTEGER32);
    own.addReceivePdo({ cobId: this.cobId(0x1800, 1), transmissionType: 1, dataObjects: [status, position] });
    own.addTransmitPdo({ cobId: this.cobId(0x1400, 1), transmissionType: 254, dataObjects: [control] });
    own.addTransmitPdo({ cobId: this.cobId(0x1401, 1), transmissionType: 254, dataObjects: [target] });
  }

  async start() {
    await this.channel.start(Number(port));
    this.device.start();
  }

  stop() {
    this.device.stop();
    this.channel.stop();
  }

  typeOf(index, subIndex) {
    const object = this.eds.getEntry(index);
    return (object.subNumber === undefined ? object : object.at(subIndex)).dataType;
  }

  read(index, subIndex = 0, options = {}) {
    const dataType = this.eds.getEntry(index) ? this.typeOf(index, subIndex) : DataType.UNSIGNED32;
    return this.device.sdo.upload({ serverId: NODE, index, subIndex, dataType, timeout: PATIENCE_MS, ...options });
  }

  write(index, subIndex, data) {
    return this.device.sdo.download({ serverId: NODE, index, subIndex, data, dataType: this.typeOf(index, subIndex),
                                      timeout: PATIENCE_MS });
  }

  /** The abort code with which an access ends; 0: it succeeds. */
  async abortOf(access) {
    try {
      await access;
      return 0;
    } catch (error) {
      if (error instanceof SdoError) return error.code;
      throw error;
    }
  }

  /** Maps objects of the drive into the PDO with the communication object `index`. */
  async map(index, type, objects) {
    const identifier = await this.read(index, 1);
    await this.write(index, 1, (identifier | 0x80000000) >>> 0);
    await this.write(index, 2, type);
    await this.write(index + 0x200, 0, 0);
    for (const [i, object] of objects.entries()) {
      const bits = 8 * this.eds.getEntry(object).size;
      await this.write(index + 0x200, i + 1, ((object << 16) | bits) >>> 0);
    }
    await this.write(index + 0x200, 0, objects.length);
    await this.write(index, 1, identifier);
  }

  get status() {
    return this.device.getValue(STATUS);
  }

  async command(word, mask, expected) {
    this.device.setValue(CONTROL, word);
    await until(`status ${expected.toString(16)} after control word ${word.toString(16)}`,
                () => (this.status & mask) === expected);
  }
}

/** All entries of the sheet below an index range that the drive must have with the same type and default. */
async function compareWithSheet(master) {
  const seen = { compared: 0, read: 0, differ: [] };
  const SIZES = { 1: 1, 2: 1, 3: 2, 4: 4, 5: 1, 6: 2, 7: 4, 8: 4 };
  const compare = async (index, subIndex, entry) => {
    const size = SIZES[entry.dataType];
    if (size === undefined || entry.accessType === "wo") return;
    const raw = await master.device.sdo.upload({ serverId: NODE, index, subIndex, dataType: DataType.OCTET_STRING,
                                                 timeout: PATIENCE_MS });
    const name = `${index.toString(16)}:${subIndex}`;
    seen.read++;
    if (raw.length !== size) {
      seen.differ.push([name, "size", raw.length, size]);
      return;
    }
    const expected = numberOf(entry.defaultValue);
    if (expected === null || entry.dataType === DataType.REAL32 || !entry.accessType.startsWith("rw")) return;
    const wrapped = BigInt.asUintN(8 * size, BigInt(Math.trunc(expected)));
    const actual = BigInt.asUintN(8 * size, BigInt(raw.readUIntLE(0, size)));
    if (actual !== wrapped) seen.differ.push([name, "value", Number(actual), Number(wrapped)]);
    seen.compared++;
  };
  for (const object of master.eds.values()) {
    const index = object.index;
    if (!((index >= 0x1000 && index < 0x2000) || (index >= 0x6000 && index < 0x6800))) continue;
    if (object.subNumber === undefined) {
      await compare(index, 0, object);
      continue;
    }
    for (let i = 0; i < 256; i++) {
      if (object.at(i)) await compare(index, i, object.at(i));
    }
  }
  return seen;
}

async function services(master) {
  const seen = { device_type: await master.read(0x1000), name: await master.read(0x1008) };
  const text = "the axis that a module of npm moves";
  await master.write(0x2003, 0, text);
  seen.text_back = (await master.read(0x2003)) === text;
  seen.missing = await master.abortOf(master.read(0x5fff));
  seen.read_only = await master.abortOf(master.write(0x6041, 0, 7));
  seen.no_block_transfer = await master.abortOf(master.read(0x2003, 0, { blockTransfer: true }));
  return seen;
}

/** NMT commands, and the states that heartbeats report after them. */
async function states(master) {
  const { device, heartbeats } = master;
  const after = async (deed, state) => {
    const before = heartbeats.length;
    await deed();
    await until(`heartbeat ${state}`, () => heartbeats.slice(before).includes(state));
  };
  await after(() => master.write(0x1017, 0, 40), 127);
  await after(() => device.nmt.startNode(NODE), 5);
  await after(() => device.nmt.stopNode(NODE), 4);
  await after(() => device.nmt.enterPreOperational(NODE), 127);
  // The reset ends the heartbeats, which are not stored: the boot-up message is the last one.
  await after(() => device.nmt.resetCommunication(NODE), 0);
  await until("the end of the heartbeats", () => heartbeats.at(-1) === "lost");
  return { heartbeats: [...new Set(heartbeats)] };
}

/** A profile move: objects by SDO, mapping, control word and target by PDO, status and position by SYNC. */
async function move(master) {
  const { device } = master;
  const TURN = 2 ** 20;
  await master.write(0x6081, 0, 20 * TURN);
  await master.write(0x6083, 0, 100 * TURN);
  await master.write(0x6084, 0, 90 * TURN);
  await master.write(0x6060, 0, 1);
  await master.map(0x1400, 255, [0x6040]);
  await master.map(0x1401, 255, [0x607a]);
  await master.map(0x1800, 1, [0x6041, 0x6064]);
  const start = await master.read(0x6064);
  device.nmt.startNode(NODE);
  device.nmt.startNode(); // itself: PDOs are exchanged in this state only
  device.eds.setSyncCyclePeriod(10_000);
  await until("a status word with a SYNC", () => master.status !== 0);
  for (const [word, state] of [[6, 0x21], [7, 0x23], [15, 0x27]]) await master.command(word, 0x6f, state);
  const target = start + 3 * TURN + 777;
  device.setValue(TARGET, target);
  const deadline = Date.now() + PATIENCE_MS;
  while ((await master.read(0x607a)) !== target) {
    if (Date.now() > deadline) throw new Error("the target never came to the drive");
  }
  await master.command(0x1f, 0x1000, 0x1000);
  await master.command(0x0f, 0x1400, 0x0400);
  const seen = { distance: (await master.read(0x6064)) - start, by_pdo: device.getValue(POSITION) - start, syncs: master.syncs };
  // Operational is left with the power on: a fault, and its message.
  device.nmt.enterPreOperational(NODE);
  await until("an emergency", () => master.emergencies.length > 0);
  // Acknowledged when the motor is off.
  for (const end = Date.now() + PATIENCE_MS; master.emergencies.length < 2;) {
    if (Date.now() > end) throw new Error("the fault is never acknowledged");
    await master.write(0x2099, 0, 1);
    await new Promise((done) => setTimeout(done, 20));
  }
  return { ...seen, emergencies: master.emergencies };
}

async function main() {
  if (calculateCrc(Buffer.from("123456789")) !== 0x31c3) throw new Error("the CRC of the test is wrong");
  const master = new Master(Eds.fromFile(sheet));
  await master.start();
  const seen = { sheet: await compareWithSheet(master), services: await services(master), states: await states(master),
                 move: await move(master) };
  seen.refused = master.channel.refused;
  master.stop();
  console.log(JSON.stringify(seen));
}

main().then(() => process.exit(0), (error) => {
  console.error(error);
  process.exit(1);
});
