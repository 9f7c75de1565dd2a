// read_eds.cjs FILE FOLDER [COPY]: reads an electronic data sheet with the npm module canopen, which FOLDER/node_modules has,
// and prints what it found as JSON; writes it with the same module to COPY.
const { createRequire } = require("node:module");
const { resolve } = require("node:path");

const [, , file, folder, copy] = process.argv;
// Only the data sheets: the rest of the module needs a native one, which npm ci --ignore-scripts does not build.
const { Eds } = createRequire(resolve(folder, "package.json"))("canopen/source/eds.js");

const eds = Eds.fromFile(file);
const entries = {};
const add = (index, subIndex, entry) => {
  entries[`${index.toString(16)}:${subIndex.toString(16)}`] = {
    name: entry.parameterName, type: entry.dataType, access: entry.accessType, value: entry.defaultValue,
    low: entry.lowLimit, high: entry.highLimit, mapping: entry.pdoMapping,
  };
};
for (const object of eds.values()) {
  if (object.subNumber === undefined) add(object.index, 0, object);
  for (let i = 0; i < 256 && object.subNumber !== undefined; i++) {
    const entry = object.at(i);
    if (entry) add(object.index, i, entry);
  }
}
console.log(JSON.stringify({ vendor: eds.vendorNumber, product: eds.productNumber, revision: eds.revisionNumber,
                             rates: eds.baudRates, entries }));
if (copy) {
  // Sections that a sheet may leave out, and save() expects.
  eds.dummyUsage ??= {};
  eds.comments ??= { Lines: 0 };
  eds.save(copy);
}
