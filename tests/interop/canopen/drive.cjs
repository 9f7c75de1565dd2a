// drive.cjs PORT FOLDER SHEET NODE: the npm module canopen, which FOLDER/node_modules has, as a CiA 402 drive with the node-ID NODE
// for a foreign master. The module does NMT, SDO, heartbeat and PDO by the sheet SHEET, and lets a program add what it leaves out:
// the boot-up message, the state machine of the drive, and its motor, which is where it is told to be with the next SYNC.
// Sends and receives by the slcan door at 127.0.0.1:PORT. At the end of its input it prints what it has seen as one JSON document.
const { SlcanChannel, loadCanopen } = require("./slcan.cjs");

const [, , port, folder, sheet, nodeText] = process.argv;
const NODE = Number(nodeText);
const { Device, Eds } = loadCanopen(folder);

const INITIALISING = 0, OPERATIONAL = 5, PRE_OPERATIONAL = 127;
const INTERPOLATED = 7;
// Bits of 6041h under the mask 6Fh (CiA 402-2); bit 4: voltage, bit 9: remote, bit 12: interpolated position is active.
const SWITCH_ON_DISABLED = 0x40, READY = 0x21, SWITCHED_ON = 0x23, ENABLED = 0x27, QUICK_STOP = 0x07, FAULT = 0x08;
const ALWAYS = 0x0210, IN_MOTION = 0x1000;

/** The state machine of CiA 402-2, as far as a master sees it. */
function nextState(state, word) {
  if (state === FAULT) return word & 0x80 ? SWITCH_ON_DISABLED : FAULT;
  if (!(word & 0x02)) return SWITCH_ON_DISABLED;
  if (!(word & 0x04)) return state === ENABLED || state === QUICK_STOP ? QUICK_STOP : SWITCH_ON_DISABLED;
  switch (word & 0x0f) {
    case 0x06: return READY;
    case 0x07: return state === SWITCH_ON_DISABLED ? state : SWITCHED_ON;
    case 0x0f: return state === SWITCH_ON_DISABLED ? state : state === READY ? SWITCHED_ON : ENABLED;
    default: return state;
  }
}

class Drive {
  constructor() {
    this.seen = { states: [], setting: null, master_lost: 0, syncs: 0, furthest: 0, enabled: false };
    this.state = SWITCH_ON_DISABLED;
    this.master = null; // whose heartbeat is expected
    this.device = new Device({ id: NODE, eds: Eds.fromFile(sheet) });
    this.channel = new SlcanChannel((message) => this.receive(message));
    this.device.addListener("message", (message) => this.channel.send(message));
    this.device.nmt.addListener("changeState", (state) => this.entered(state));
    this.device.nmt.addListener("timeout", () => this.lost());
    this.eds = this.device.eds;
  }

  async start() {
    await this.channel.start(Number(port));
    this.device.start();
  }

  entered(state) {
    const before = this.seen.states.at(-1) ?? INITIALISING;
    this.seen.states.push(state);
    // The module sends no boot-up message, and event-driven PDOs only when a value changes.
    if (state === PRE_OPERATIONAL && before === INITIALISING) this.channel.send({ id: 0x700 + NODE, data: [0] });
    if (state === OPERATIONAL) setImmediate(() => this.sendFirstValues());
  }

  sendFirstValues() {
    for (const pdo of this.eds.getTransmitPdos()) {
      if (pdo.transmissionType >= 0xfe) this.device.pdo.write(pdo.cobId);
    }
  }

  receive(message) {
    this.device.receive(message);
    if (message.id === 0x80 && this.device.state === OPERATIONAL) this.synchronised();
  }

  /** The master is gone: the drive stops where it is, and tells. */
  lost() {
    this.seen.master_lost++;
    this.state = FAULT;
    this.eds.getEntry(0x603f).value = 0x8130;
    this.show();
    this.device.emcy.write(0x8130, Buffer.alloc(5));
  }

  synchronised() {
    this.seen.syncs++;
    this.seen.setting = this.eds.getEntry(0x2001).value;
    this.state = nextState(this.state, this.eds.getEntry(0x6040).value);
    const mode = this.eds.getEntry(0x6060).value;
    this.eds.getEntry(0x6061).value = mode;
    const position = this.eds.getEntry(0x6064);
    if (this.state === ENABLED && mode === INTERPOLATED) {
      this.seen.enabled = true;
      if (this.eds.getEntry(0x6040).value & 0x10) position.value = this.eds.getEntry(0x60c1)[1].value;
    }
    this.seen.furthest = Math.max(this.seen.furthest, position.value);
    this.show();
  }

  show() {
    const moves = this.state === ENABLED && this.eds.getEntry(0x6040).value & 0x10;
    this.eds.getEntry(0x6041).value = this.state | ALWAYS | (moves ? IN_MOTION : 0);
  }
}

const drive = new Drive();
drive.start().catch((error) => {
  console.error(error);
  process.exit(1);
});
process.stdin.on("data", () => {});
process.stdin.on("end", () => {
  const { seen, eds } = drive;
  console.log(JSON.stringify({ ...seen, position: eds.getEntry(0x6064).value, state: drive.state }));
  process.exit(0);
});
