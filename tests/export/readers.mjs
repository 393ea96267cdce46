// What the packages fold and rabbit-ear make of a FOLD file, as JSON: node readers.mjs FILE
import fs from "node:fs";
import FOLD from "fold";
import ear from "rabbit-ear";

const text = fs.readFileSync(process.argv[2], "utf8");
const file = JSON.parse(text);
const apart = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));

const read = FOLD.convert.deepCopy(file);
FOLD.convert.faces_vertices_to_faces_edges(read);
FOLD.convert.edges_vertices_to_edges_faces_edges(read);
const kinds = ["mountainEdges", "valleyEdges", "flatEdges", "boundaryEdges", "unassignedEdges", "cutEdges", "joinEdges"];
const fold = {
  counts: [FOLD.filter.numVertices(read), FOLD.filter.numEdges(read), FOLD.filter.numFaces(read)],
  kinds: Object.fromEntries(kinds.map((kind) => [kind, FOLD.filter[kind](read).length])),
  edgesFaces: read.edges_faces.map((faces) => faces.filter((face) => face !== null && face !== undefined).length),
  again: JSON.stringify(JSON.parse(FOLD.convert.toJSON(file))) === JSON.stringify(file),
};

const folded = { ...file, ...file.file_frames[0] };
delete folded.file_frames;
const flat = ear.graph({ ...file });
const still = (face) => face.every((v) => apart(file.vertices_coords[v], folded.vertices_coords[v]) < 1e-6);
const root = file.faces_vertices.findIndex(still);
const made = ear.graph.makeVerticesCoordsFlatFolded(flat, [root]);
const laid = ear.graph({ ...folded });
delete laid.faceOrders;
laid.populate();
const solved = ear.layer.solver(laid);
console.log(JSON.stringify({
  fold,
  counts: [ear.graph.count.vertices(file), ear.graph.count.edges(file), ear.graph.count.faces(file)],
  summary: ear.graph.validate(file).summary,
  missed: Math.max(...made.map((point, v) => apart(point, folded.vertices_coords[v]))),
  orders: solved.root,
  branches: solved.branches,
}));
