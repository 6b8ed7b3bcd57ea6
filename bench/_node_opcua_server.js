// The node-opcua server of bench/opcua.py; _opcua_servers.py says by which rules a server plays.
"use strict";

const path = require("path");
const readline = require("readline");
const { OPCUAServer } = require("node-opcua-server");
const { OPCUACertificateManager } = require("node-opcua-certificate-manager");
const { MessageSecurityMode, SecurityPolicy } = require("node-opcua-secure-channel");
const { DataType } = require("node-opcua-variant");

const HOST = "127.0.0.1";
const PER_FOLDER = 100;
const PER_PLC = 2000;
const MOVING = 1000;
const PERIOD = 100; // ms

const options = {};
for (let n = 2; n < process.argv.length; n += 2) options[process.argv[n].slice(2)] = process.argv[n + 1];
const items = Number(options.items);
const two = (n) => String(n).padStart(2, "0");

let changing = false;
const told = readline.createInterface({ input: process.stdin });
told.on("line", (line) => { changing = line.trim() === "go"; });
told.on("close", () => process.exit(0));

function addItems(addressSpace, namespace) {
  const moving = [];
  let plc;
  let folder;
  for (let n = 0; n < items; n++) {
    const place = n % PER_PLC;
    const plcId = `Soft.P${two(Math.floor(n / PER_PLC))}`;
    const folderId = `${plcId}.F${two(Math.floor(place / PER_FOLDER))}`;
    if (place === 0) {
      plc = namespace.addFolder(addressSpace.rootFolder.objects, { browseName: plcId, nodeId: `s=${plcId}` });
    }
    if (place % PER_FOLDER === 0) folder = namespace.addFolder(plc, { browseName: folderId, nodeId: `s=${folderId}` });
    const kind = n % 2 === 0 ? DataType.Float : DataType.Int16;
    const name = `I${two(n % PER_FOLDER)}`;
    const variable = namespace.addVariable({
      organizedBy: folder,
      browseName: name,
      nodeId: `s=${folderId}.${name}`,
      dataType: kind,
      value: { dataType: kind, value: 0 },
      accessLevel: "CurrentRead | CurrentWrite",
      userAccessLevel: "CurrentRead | CurrentWrite",
    });
    if (n < MOVING) moving.push([variable, kind]);
  }
  return moving;
}

async function main() {
  const secured = options.certificate !== undefined;
  const store = new OPCUACertificateManager({
    automaticallyAcceptUnknownCertificate: true,
    rootFolder: path.join(process.env.HOME, "node-opcua-pki"),
  });
  const server = new OPCUAServer({
    host: HOST,
    port: Number(options.port),
    serverInfo: { applicationUri: "urn:pcaccess:bench" },
    serverCertificateManager: store,
    securityPolicies: secured ? [SecurityPolicy.None, SecurityPolicy.Basic256Sha256] : [SecurityPolicy.None],
    securityModes: secured ? [MessageSecurityMode.None, MessageSecurityMode.SignAndEncrypt] : [MessageSecurityMode.None],
    ...(secured ? { certificateFile: options.certificate, privateKeyFile: options.key } : {}),
  });
  await server.initialize();
  const addressSpace = server.engine.addressSpace;
  const namespace = addressSpace.registerNamespace("urn:bench");
  const moving = addItems(addressSpace, namespace);
  await server.start();
  let turn = 0;
  setInterval(() => {
    if (!changing) return;
    turn += 1;
    moving.forEach(([variable, dataType], n) => {
      variable.setValueFromSource({ dataType, value: (turn + n) % 30000 });
    });
  }, PERIOD);
  console.log(`ready ${options.port} ${namespace.index}`);
}

main().catch((problem) => {
  console.error(String(problem));
  process.exit(1);
});
