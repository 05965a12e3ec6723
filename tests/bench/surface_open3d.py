"""Open3D's TSDF on the frames that bench_surface wrote: surface_open3d.py FOLDER

Writes FOLDER/NAME.ply and FOLDER/NAME.ms (the median time of a frame) for its two volumes, at our voxel and truncation
and at the truncation of two voxels that its examples have. Exits with 77 where Open3D is not installed (python3-open3d).
"""
import statistics
import subprocess
import sys
import time
from pathlib import Path

try:
    import numpy as np
    import open3d as o3d
except ImportError:
    sys.exit(77)

VOXEL_M = 0.02


def frames(folder):
    width, height, fx, fy, cx, cy, scale, farthest = map(float, (folder / "intrinsics.txt").read_text().split())
    width, height = int(width), int(height)
    poses = np.loadtxt(folder / "poses.txt").reshape(-1, 4, 4)
    depth = np.fromfile(folder / "depth.bin", np.uint16).reshape(-1, height, width)
    rgb = np.fromfile(folder / "rgb.bin", np.uint8).reshape(-1, height, width, 3)
    camera = o3d.camera.PinholeCameraIntrinsic(width, height, fx, fy, cx, cy)
    return camera, scale, farthest, list(zip(rgb, depth, [np.linalg.inv(T) for T in poses]))


def scalable(folder, name, truncation_m):
    camera, scale, farthest, seen = frames(folder)
    volume = o3d.pipelines.integration.ScalableTSDFVolume(
        VOXEL_M, truncation_m, o3d.pipelines.integration.TSDFVolumeColorType.RGB8)
    times = []
    for rgb, depth, T_camera_world in seen:
        image = o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(np.ascontiguousarray(rgb)), o3d.geometry.Image(np.ascontiguousarray(depth)),
            depth_scale=scale, depth_trunc=farthest, convert_rgb_to_intensity=False)
        begin = time.thread_time()
        volume.integrate(image, camera, T_camera_world)
        times.append(1e3 * (time.thread_time() - begin))
    o3d.io.write_triangle_mesh(str(folder / f"{name}.ply"), volume.extract_triangle_mesh())
    (folder / f"{name}.ms").write_text(f"{statistics.median(times):.2f}\n")


def block_grid(folder, name, truncation_voxels):
    camera, scale, farthest, seen = frames(folder)
    cpu, core = o3d.core.Device("CPU:0"), o3d.core
    grid = o3d.t.geometry.VoxelBlockGrid(
        ("tsdf", "weight", "color"), (core.float32, core.float32, core.float32), ((1), (1), (3)),
        voxel_size=VOXEL_M, block_resolution=8, block_count=60000, device=cpu)
    K = core.Tensor(camera.intrinsic_matrix)
    times = []
    for rgb, depth, T_camera_world in seen:
        color_image = o3d.t.geometry.Image(core.Tensor(np.ascontiguousarray(rgb)))
        depth_image = o3d.t.geometry.Image(core.Tensor(np.ascontiguousarray(depth)))
        T = core.Tensor(T_camera_world)
        begin = time.process_time()
        blocks = grid.compute_unique_block_coordinates(depth_image, K, T, scale, farthest, truncation_voxels)
        grid.integrate(blocks, depth_image, color_image, K, T, scale, farthest, truncation_voxels)
        times.append(1e3 * (time.process_time() - begin))
    mesh = grid.extract_triangle_mesh(weight_threshold=2.0).to_legacy()
    o3d.io.write_triangle_mesh(str(folder / f"{name}.ply"), mesh)
    (folder / f"{name}.ms").write_text(f"{statistics.median(times):.2f}\n")


def main():
    if len(sys.argv) == 2:  # each volume in a process of its own: the block grid's extraction may end it
        for which in ("scalable", "blockgrid"):
            for voxels in ("2", "3"):
                if subprocess.run([sys.executable, __file__, sys.argv[1], which, voxels], check=False).returncode != 0:
                    print(f"{which}-{voxels} failed")
        return
    folder, which, voxels = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    if which == "scalable":
        scalable(folder, f"{which}-{voxels}", voxels * VOXEL_M)
    else:
        block_grid(folder, f"{which}-{voxels}", float(voxels))


main()
