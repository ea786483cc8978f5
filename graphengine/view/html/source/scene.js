// Draws the world: all shapes of a stage are instances of their surfaces, and those of moving bodies are placed in each frame.

import {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, FrontSide, Group, HemisphereLight, InstancedMesh, Matrix4,
  MeshLambertMaterial, Object3D, PerspectiveCamera, Points, PointsMaterial, Quaternion, RepeatWrapping, Scene, SRGBColorSpace,
  Texture, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { lastBefore } from "./decode.js";

const FAR = 10; // m; points beyond have the same colour
const VIEW = new Vector3(-2.7, -0.6, 1.7); // m from the target to the camera: behind a robot, where it came from
const UP = new Vector3(0, 0, 1);

Object3D.DEFAULT_UP.copy(UP);

// Returns position, rotation and scale at some place of arrays as a matrix.
function matrix(poses, index, scales) {
  const [x, y, z, ...turn] = poses.subarray(7 * index, 7 * index + 7);
  const scale = scales ? new Vector3().fromArray(scales, 3 * index) : new Vector3(1, 1, 1);
  return new Matrix4().compose(new Vector3(x, y, z), new Quaternion(...turn), scale);
}

// A part of the run in which the same bodies exist.
class Stage {
  constructor(data, surfaces, textures) {
    this.data = data;
    this.group = new Group();
    this.bodies = Array.from({ length: data.rest.length / 7 }, (_, row) => matrix(data.rest, row));
    this.moving = new Set(data.moving);
    this.batches = data.batches.map((batch) => this.draw(batch, surfaces[batch.surface], textures[batch.texture] ?? null));
    this.lidars = data.lidars.map((lidar) => new Lidar(lidar));
    this.group.add(...this.batches.map((batch) => batch.mesh), ...this.lidars.map((lidar) => lidar.points));
  }

  draw(batch, surface, texture) {
    const material = new MeshLambertMaterial({
      flatShading: true, map: texture, side: batch.double ? DoubleSide : FrontSide,
      transparent: batch.opacity < 1, opacity: batch.opacity, depthWrite: batch.opacity === 1,
    });
    const mesh = new InstancedMesh(surface, material, batch.rows.length);
    mesh.frustumCulled = false;
    const places = [...batch.rows].map((row, index) => ({ row, index, local: matrix(batch.poses, index, batch.scales) }));
    const colour = new Color();
    for (const { index } of places) {
      const [red, green, blue] = batch.colours.subarray(3 * index, 3 * index + 3);
      mesh.setColorAt(index, colour.setRGB(red / 255, green / 255, blue / 255, SRGBColorSpace));
    }
    this.place(mesh, places);
    return { mesh, places: places.filter(({ row }) => this.moving.has(row)) };
  }

  place(mesh, places) {
    const world = new Matrix4();
    for (const { row, index, local } of places) mesh.setMatrixAt(index, world.multiplyMatrices(this.bodies[row], local));
    mesh.instanceMatrix.needsUpdate ||= places.length > 0;
  }

  show(time) {
    const { times, moving, poses } = this.data;
    const before = Math.max(lastBefore(times, time), 0);
    const after = Math.min(before + 1, times.length - 1);
    const share = after > before ? Math.min(Math.max((time - times[before]) / (times[after] - times[before]), 0), 1) : 0;
    const [from, to] = [before, after].map((sample) => (part) => poses[part * times.length + sample]);
    moving.forEach((row, index) => {
      const [start, end] = [from, to].map((at) => Array.from({ length: 7 }, (_, part) => at(7 * index + part)));
      const position = new Vector3(...start).lerp(new Vector3(...end), share);
      const turn = new Quaternion(...start.slice(3)).slerp(new Quaternion(...end.slice(3)), share);
      this.bodies[row].compose(position, turn, new Vector3(1, 1, 1));
    });
    for (const { mesh, places } of this.batches) this.place(mesh, places);
    for (const lidar of this.lidars) lidar.show(time);
  }
}

// The points of a lidar's newest scan; their colours show the distance.
class Lidar {
  constructor(data) {
    this.data = data;
    const geometry = new BufferGeometry();
    for (const name of ["position", "color"]) geometry.setAttribute(name, new BufferAttribute(new Float32Array(data.beams.length), 3));
    this.points = new Points(geometry, new PointsMaterial({ size: 3, sizeAttenuation: false, vertexColors: true }));
    this.points.frustumCulled = false;
  }

  show(time) {
    const { times, poses, ranges, beams } = this.data;
    const scan = lastBefore(times, time);
    this.points.visible = scan >= 0;
    if (scan < 0 || scan === this.shown) return;
    this.shown = scan;
    const { position, color } = this.points.geometry.attributes;
    const number = beams.length / 3;
    const [pose, hit, colour] = [matrix(poses, scan), new Vector3(), new Color()];
    let hits = 0;
    for (let beam = 0; beam < number; beam++) {
      const range = ranges[scan * number + beam] / 100;
      if (!range) continue;
      hit.fromArray(beams, 3 * beam).multiplyScalar(range).applyMatrix4(pose).toArray(position.array, 3 * hits);
      colour.setHSL(0.62 * Math.min(range / FAR, 1), 0.85, 0.5, SRGBColorSpace).toArray(color.array, 3 * hits++);
    }
    position.needsUpdate = color.needsUpdate = true;
    this.points.geometry.setDrawRange(0, hits);
  }
}

function geometry({ vertices, faces, coordinates }) {
  const made = new BufferGeometry();
  made.setAttribute("position", new BufferAttribute(vertices, 3));
  if (coordinates) made.setAttribute("uv", new BufferAttribute(coordinates, 2));
  if (faces) made.setIndex(new BufferAttribute(faces, 1));
  return made;
}

async function picture({ file }) {
  const texture = new Texture(await createImageBitmap(new Blob([file])));
  Object.assign(texture, { wrapS: RepeatWrapping, wrapT: RepeatWrapping, flipY: false, colorSpace: SRGBColorSpace, anisotropy: 8 });
  texture.needsUpdate = true;
  return texture;
}

// The 3D picture. `host` is the element that contains it; `moved` is called when the camera was moved.
export class World {
  static async make(host, data, moved) {
    return new World(host, data, await Promise.all(data.textures.map(picture)), moved);
  }

  constructor(host, data, textures, moved) {
    const surfaces = data.surfaces.map(geometry);
    this.host = host;
    this.scene = new Scene();
    this.stages = data.stages.map((stage) => new Stage(stage, surfaces, textures));
    this.renderer = new WebGLRenderer({ antialias: true });
    this.camera = new PerspectiveCamera(50, 1, 0.05, 1000);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", moved);
    const sun = new DirectionalLight(0xffffff, 1.5);
    sun.position.set(4, -6, 10);
    this.scene.add(new HemisphereLight(0xffffff, 0x9a958c, 2), sun, ...this.stages.map((stage) => stage.group));
    host.append(this.renderer.domElement);
    this.camera.position.copy(VIEW);
    this.followed = data.stages[0].robots[0]?.[0] ?? "";
    this.before = { position: new Vector3(), heading: 0 };
    this.show(0);
  }

  // Follows another robot from the same side; the name of none ends it.
  follow(name) {
    this.followed = name;
    this.before = null;
    this.track();
  }

  // Returns the position, m, and the heading, rad, of a robot; null while it does not exist.
  poseOf(name) {
    const row = this.stage.data.robots.find(([robot]) => robot === name)?.[1];
    if (row === undefined) return null;
    const { elements } = this.stage.bodies[row];
    return { position: new Vector3().fromArray(elements, 12), heading: Math.atan2(elements[1], elements[0]) };
  }

  show(time) {
    this.stage = this.stages.findLast((stage) => stage.data.times[0] <= time) ?? this.stages[0];
    for (const stage of this.stages) stage.group.visible = stage === this.stage;
    this.stage.show(time);
    this.track();
  }

  // Moves and turns the camera with the followed robot.
  track() {
    const pose = this.poseOf(this.followed);
    if (pose) {
      const { target } = this.controls;
      const before = this.before ?? { ...pose, position: target.clone() };
      const offset = this.camera.position.clone().sub(target).applyAxisAngle(UP, pose.heading - before.heading);
      target.add(pose.position).sub(before.position);
      this.camera.position.copy(target).add(offset);
    }
    this.controls.update();
    this.before = pose;
  }

  render() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width !== this.width || height !== this.height) {
      Object.assign(this, { width, height });
      this.renderer.setPixelRatio(window.devicePixelRatio);
      this.renderer.setSize(width, height);
      this.camera.aspect = width / Math.max(height, 1);
      this.camera.updateProjectionMatrix();
    }
    this.scene.background = new Color(getComputedStyle(this.host).backgroundColor);
    this.renderer.render(this.scene, this.camera);
  }
}
