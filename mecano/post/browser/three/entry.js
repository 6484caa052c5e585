// What of three.js the pages use. three.min.js is made of it, with three 0.187.0 and esbuild 0.28.2 of the npm registry:
//   esbuild entry.js --bundle --minify --format=iife --global-name=THREE --banner:js="$(head -1 three.min.js)" --outfile=three.min.js
export {
  AmbientLight, BufferAttribute, BufferGeometry, CanvasTexture, Color, ConeGeometry, CylinderGeometry, DirectionalLight, DoubleSide,
  Group, HemisphereLight, IcosahedronGeometry, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Quaternion, Raycaster, Scene, SphereGeometry, Sprite, SpriteMaterial, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
