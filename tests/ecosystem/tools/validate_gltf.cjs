// The Khronos validator's verdict on one file as JSON: node validate_gltf.cjs FOLDER_OF_THE_PACKAGE FILE
const [folder, file] = process.argv.slice(2);
require(folder)
    .validateBytes(new Uint8Array(require("fs").readFileSync(file)))
    .then((report) => console.log(JSON.stringify(report)));
