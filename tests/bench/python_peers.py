#!/usr/bin/env python3
"""The same five tasks with vdblic and with other packages of Python: a table of docs/evidence.md.

    PYTHONPATH=build/release/python xvfb-run -a PYTHON tests/bench/python_peers.py [PACKAGE...]

PYTHON has the packages, pyvista, yt, xarray with matplotlib, and napari. Lines are those of the code below; names are the
different functions, members and keywords of packages in it. Every program is run, and must write what its task asks for.
"""

import ast
import importlib
import pathlib
import subprocess
import sys
import tempfile
import textwrap

TASKS = ["a scalar, as a volume", "a velocity, its flow", "a film of the flow", "a Dataset's flow", "a solver's flow"]
OUTPUTS = ["1.png", "2.png", "3.mp4", "4.png", "5.0007.png"]

GIVEN = """
import numpy
def velocity_at(time):
    x, y, z = numpy.meshgrid(*[numpy.arange(24) * 0.1] * 3, indexing="ij")
    return numpy.stack([numpy.sin(z + time), numpy.cos(x), numpy.sin(y) + numpy.cos(x + time)], axis=-1).astype("float32")
def solver():
    for step in range(8):
        yield velocity_at(step / 24)
velocity, velocities = velocity_at(0), list(solver())
speed = numpy.linalg.norm(velocity, axis=-1)
def dataset():
    import xarray
    axes = {axis: (axis, numpy.arange(24) * 0.1, {"units": "m"}) for axis in "xyz"}
    return xarray.Dataset({name: (list("xyz"), velocity[..., i]) for i, name in enumerate("uvw")}, axes)
"""

PROGRAMS = {
    "vdblic": [
        'vdblic.Renderer()(vdblic.as_volume(speed, voxel_size=0.1)).save("1.png")',
        'vdblic.film([velocity] * 8, "2.png", voxel_size=0.1)',
        'vdblic.film(velocities, "3.mp4", voxel_size=0.1, seconds=1)',
        'vdblic.film(dataset(), "4.png")',
        """
        render = vdblic.Renderer()
        with vdblic.Flow(voxel_size=0.1) as flow:
            for velocity in solver():
                for texture in flow.push(velocity):
                    render(texture).save(f"5.{texture.frame:04}.png")
        """,
    ],
    "pyvista": [
        """
        grid = pyvista.ImageData(dimensions=speed.shape, spacing=(0.1, 0.1, 0.1))
        grid["speed"] = speed.ravel(order="F")
        plotter = pyvista.Plotter(off_screen=True)
        plotter.add_volume(grid)
        plotter.screenshot("1.png")
        """,
        """
        grid = pyvista.ImageData(dimensions=velocity.shape[:3], spacing=(0.1, 0.1, 0.1))
        grid["velocity"] = velocity.reshape(-1, 3, order="F")
        plotter = pyvista.Plotter(off_screen=True)
        plotter.add_mesh(grid.streamlines("velocity", source_radius=1).tube(radius=0.01))
        plotter.screenshot("2.png")
        """,
        """
        plotter = pyvista.Plotter(off_screen=True)
        plotter.open_movie("3.mp4")
        for velocity in velocities:
            grid = pyvista.ImageData(dimensions=velocity.shape[:3], spacing=(0.1, 0.1, 0.1))
            grid["velocity"] = velocity.reshape(-1, 3, order="F")
            plotter.add_mesh(grid.streamlines("velocity", source_radius=1).tube(radius=0.01), name="lines")
            plotter.write_frame()
        plotter.close()
        """,
        """
        data = dataset()
        spacing = [float(data[axis][1] - data[axis][0]) for axis in "xyz"]
        grid = pyvista.ImageData(dimensions=data.u.shape, spacing=spacing)
        grid["velocity"] = numpy.stack([data[name].values.ravel(order="F") for name in "uvw"], axis=-1)
        plotter = pyvista.Plotter(off_screen=True)
        plotter.add_mesh(grid.streamlines("velocity", source_radius=1).tube(radius=0.01))
        plotter.screenshot("4.png")
        """,
        """
        plotter = pyvista.Plotter(off_screen=True)
        for number, velocity in enumerate(solver(), 1):
            grid = pyvista.ImageData(dimensions=velocity.shape[:3], spacing=(0.1, 0.1, 0.1))
            grid["velocity"] = velocity.reshape(-1, 3, order="F")
            plotter.add_mesh(grid.streamlines("velocity", source_radius=1).tube(radius=0.01), name="lines")
            plotter.screenshot(f"5.{number:04}.png")
        """,
    ],
    "yt": [
        """
        data = yt.load_uniform_grid({"speed": speed}, speed.shape, bbox=numpy.array([[0, 2.4]] * 3))
        yt.create_scene(data, ("stream", "speed")).save("1.png")
        """,
        """
        parts = {f"velocity_{axis}": velocity[..., i] for i, axis in enumerate("xyz")}
        data = yt.load_uniform_grid(parts, velocity.shape[:3], bbox=numpy.array([[0, 2.4]] * 3))
        plot = yt.SlicePlot(data, "z", ("stream", "velocity_x"))
        plot.annotate_line_integral_convolution(("stream", "velocity_x"), ("stream", "velocity_y"))
        plot.save("2.png")
        """,
        """
        with imageio.get_writer("3.mp4", fps=24) as film:
            for velocity in velocities:
                parts = {f"velocity_{axis}": velocity[..., i] for i, axis in enumerate("xyz")}
                data = yt.load_uniform_grid(parts, velocity.shape[:3], bbox=numpy.array([[0, 2.4]] * 3))
                plot = yt.SlicePlot(data, "z", ("stream", "velocity_x"))
                plot.annotate_line_integral_convolution(("stream", "velocity_x"), ("stream", "velocity_y"))
                plot.save("frame.png")
                film.append_data(imageio.imread("frame.png"))
        """,
        """
        given = dataset()
        bbox = numpy.array([[float(given[axis][0]), float(given[axis][-1])] for axis in "xyz"])
        parts = {f"velocity_{axis}": given[name].values for axis, name in zip(list("xyz"), "uvw")}
        data = yt.load_uniform_grid(parts, given.u.shape, bbox=bbox)
        plot = yt.SlicePlot(data, "z", ("stream", "velocity_x"))
        plot.annotate_line_integral_convolution(("stream", "velocity_x"), ("stream", "velocity_y"))
        plot.save("4.png")
        """,
        """
        for number, velocity in enumerate(solver(), 1):
            parts = {f"velocity_{axis}": velocity[..., i] for i, axis in enumerate("xyz")}
            data = yt.load_uniform_grid(parts, velocity.shape[:3], bbox=numpy.array([[0, 2.4]] * 3))
            plot = yt.SlicePlot(data, "z", ("stream", "velocity_x"))
            plot.annotate_line_integral_convolution(("stream", "velocity_x"), ("stream", "velocity_y"))
            plot.save(f"5.{number:04}.png")
        """,
    ],
    "xarray": [
        """
        data = xarray.DataArray(speed, dims=("x", "y", "z"), coords={axis: numpy.arange(24) * 0.1 for axis in "xyz"})
        data.isel(z=12).plot(x="x")
        plt.savefig("1.png")
        """,
        """
        places = {axis: numpy.arange(24) * 0.1 for axis in "xyz"}
        data = xarray.Dataset({name: (list("xyz"), velocity[..., i]) for i, name in enumerate("uvw")}, places)
        data.isel(z=12).plot.streamplot(x="x", y="y", u="u", v="v")
        plt.savefig("2.png")
        """,
        """
        places = {axis: numpy.arange(24) * 0.1 for axis in "xyz"}
        def draw(number):
            plt.clf()
            parts = {name: (list("xyz"), velocities[number][..., i]) for i, name in enumerate("uvw")}
            xarray.Dataset(parts, places).isel(z=12).plot.streamplot(x="x", y="y", u="u", v="v")
        FuncAnimation(plt.figure(), draw, frames=len(velocities)).save("3.mp4", fps=24)
        """,
        """
        dataset().isel(z=12).plot.streamplot(x="x", y="y", u="u", v="v")
        plt.savefig("4.png")
        """,
        """
        places = {axis: numpy.arange(24) * 0.1 for axis in "xyz"}
        for number, velocity in enumerate(solver(), 1):
            plt.clf()
            data = xarray.Dataset({name: (list("xyz"), velocity[..., i]) for i, name in enumerate("uvw")}, places)
            data.isel(z=12).plot.streamplot(x="x", y="y", u="u", v="v")
            plt.savefig(f"5.{number:04}.png")
        """,
    ],
    "napari": [
        """
        viewer = napari.Viewer(show=False, ndisplay=3)
        viewer.add_image(speed, scale=(0.1, 0.1, 0.1))
        viewer.screenshot("1.png")
        """,
        """
        places = numpy.argwhere(numpy.ones(velocity.shape[:3]))[::8] * 0.1
        viewer = napari.Viewer(show=False, ndisplay=3)
        viewer.add_vectors(numpy.stack([places, velocity.reshape(-1, 3)[::8]], axis=1), length=0.1)
        viewer.screenshot("2.png")
        """,
        """
        places = numpy.argwhere(numpy.ones(velocity.shape[:3]))[::8] * 0.1
        viewer = napari.Viewer(show=False, ndisplay=3)
        with imageio.get_writer("3.mp4", fps=24) as film:
            for velocity in velocities:
                viewer.layers.clear()
                viewer.add_vectors(numpy.stack([places, velocity.reshape(-1, 3)[::8]], axis=1), length=0.1)
                film.append_data(viewer.screenshot()[..., :3])
        """,
        """
        data = dataset()
        vectors = numpy.stack([data[name].values for name in "uvw"], axis=-1)
        places = numpy.stack(numpy.meshgrid(*[data[axis] for axis in "xyz"], indexing="ij"), axis=-1)
        viewer = napari.Viewer(show=False, ndisplay=3)
        viewer.add_vectors(numpy.stack([places.reshape(-1, 3), vectors.reshape(-1, 3)], axis=1)[::8], length=0.1)
        viewer.screenshot("4.png")
        """,
        """
        places = numpy.argwhere(numpy.ones(velocity.shape[:3]))[::8] * 0.1
        viewer = napari.Viewer(show=False, ndisplay=3)
        for number, velocity in enumerate(solver(), 1):
            viewer.layers.clear()
            viewer.add_vectors(numpy.stack([places, velocity.reshape(-1, 3)[::8]], axis=1), length=0.1)
            viewer.screenshot(f"5.{number:04}.png")
        """,
    ],
}
IMPORTS = {
    "yt": "import yt, imageio",
    "napari": "import napari, imageio",
    "xarray": "import xarray, matplotlib\nmatplotlib.use('Agg')\nimport matplotlib.pyplot as plt\nfrom matplotlib.animation import FuncAnimation",
}


def names_in(program):
    """The members and keywords that a program names."""
    names = set()
    for node in ast.walk(ast.parse(program)):
        if isinstance(node, ast.Attribute):
            names.add(node.attr)
        elif isinstance(node, ast.Call):
            names |= {keyword.arg for keyword in node.keywords}
    return names


def cell(package, task):
    """Lines and names of a package's program, which must run."""
    program = textwrap.dedent(PROGRAMS[package][task]).strip()
    text = f"{GIVEN}\n{IMPORTS.get(package, f'import {package}')}\n{program}\n"
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        done = subprocess.run([sys.executable, "-c", text], cwd=folder, text=True, capture_output=True)
        if done.returncode != 0 or not (pathlib.Path(folder) / OUTPUTS[task]).exists():
            print(f"{package}, {TASKS[task]}: {done.stderr[-500:]}", file=sys.stderr)
            return "–"
    return f"{len(program.splitlines())}, {len(names_in(program))}"


def main(packages):
    print(f"| lines, names | {' | '.join(TASKS)} |\n|---{'|---' * len(TASKS)}|")
    for package in packages:
        version = importlib.import_module(package).__version__
        print(f"| {package} {version} | {' | '.join(cell(package, task) for task in range(len(TASKS)))} |", flush=True)


main(sys.argv[1:] or list(PROGRAMS))
