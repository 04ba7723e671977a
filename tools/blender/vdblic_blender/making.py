"""Flow textures made from the scene: settings, a run in the background, its result in the scene."""

import time

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .blend_paths import absolute
from .commands import Recipe, estimate
from .framing import select_only
from .importing import import_volume, placement
from .jobs import DONE, FAILED, RUNNING, STOPPED, Job, JobError
from .lines import import_lines
from .mantaflow import NotBaked, cache_of
from .masks import mask_of
from .preferences import tools_folder
from .sequences import SequenceError, frames_of, pattern_of
from .looks import LOOK_ITEMS
from .showing import prepare_render, show
from .tools import ToolError, check_tools, find_tool
from .vdb_header import read_header

ERRORS = (ToolError, JobError, ValueError, OSError)  # errors of files, sequences, masks and caches are ValueErrors
MADE = "vdblic_made"  # property of an object: the run's textures that it shows
INTERVAL = 0.5  # seconds between looks at a run
_problems = []  # errors of the background, shown by the panel


def _is_domain(_, thing):
    return domain_settings(thing) is not None


def domain_settings(thing):
    """The settings of a Mantaflow smoke domain, or None."""
    for modifier in thing.modifiers if thing is not None else ():
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
            return modifier.domain_settings
    return None


class VDBLIC_Settings(bpy.types.PropertyGroup):
    """The settings of a texture; kept in the .blend file."""

    source: EnumProperty(
        name="Velocity",
        items=(
            ("DOMAIN", "Smoke Domain", "The baked cache of a Mantaflow domain"),
            ("FILES", "Files", "A sequence of .vdb files"),
        ),
    )
    velocity: StringProperty(name="File", subtype="FILE_PATH", description="Any file of the sequence")
    domain: PointerProperty(name="Domain", type=bpy.types.Object, poll=_is_domain)
    method: EnumProperty(
        name="Method",
        items=(
            ("STREAKS", "Streaks", "Lines with heads and tails, and nothing between: for films"),
            ("DENSE", "Dense", "A line in every voxel: for surfaces and fine structure"),
        ),
    )
    draw: EnumProperty(
        name="Draw",
        items=(
            ("LINES", "Lines", "Hair: crisp from near, light"),
            ("VOLUME", "Volume", "Voxels: for other renderers of volumes"),
        ),
    )
    spacing: FloatProperty(
        name="Spacing",
        min=0,
        max=1000,
        description="Distance between streaks in voxels of the " "velocity; 0: as many streaks as a picture holds",
    )
    refine: IntProperty(
        name="Refine",
        min=0,
        max=16,
        description="Texture voxels along each axis in a voxel of the "
        "velocity; 0: 1, of streaks what their spacing needs",
    )
    mask: PointerProperty(
        name="Mask",
        type=bpy.types.Object,
        poll=lambda _, thing: thing.type in ("MESH", "VOLUME"),
        description="Compute only inside this object",
    )
    scene_range: BoolProperty(name="Scene Range", description="Only the frames that the scene plays")
    motion_blur: BoolProperty(name="Motion Blur", description="Write the velocity into the files, for motion blur")
    look: EnumProperty(name="Look", items=LOOK_ITEMS)
    folder: StringProperty(
        name="Folder", subtype="DIR_PATH", default="//vdblic", description="Where the textures are written"
    )
    estimate: StringProperty(name="Estimate")
    shown: StringProperty(name="Shown", description="The output whose textures stand in the scene already")


def recipe_of(context, settings):
    """The recipe of the settings, and warnings. Raises one of ERRORS."""
    scene, warnings, domain = context.scene, [], None
    about = []
    if settings.source == "DOMAIN":
        domain = settings.domain
        fluid = domain_settings(domain)
        if fluid is None:
            raise NotBaked("no domain: choose a Mantaflow smoke domain of the scene, or velocities from files")
        rate = scene.render.fps / scene.render.fps_base
        cache = cache_of(
            domain.name,
            absolute(fluid.cache_directory),
            fluid.cache_data_format,
            fluid.use_adaptive_domain,
            fluid.time_scale,
            rate,
        )
        velocity, frames, about = cache.pattern, cache.frames, cache.options
    else:
        if not settings.velocity:
            raise SequenceError("no velocity: choose any file of a sequence")
        velocity = pattern_of(absolute(settings.velocity))
        frames = frames_of(velocity)
        if not frames:
            raise SequenceError(f"{absolute(settings.velocity)}: no such file; choose one that is there")
    folder = absolute(settings.folder)
    recipe = Recipe(velocity, folder, settings.method, settings.spacing, settings.refine, about_velocity=tuple(about))
    recipe.lines = settings.draw == "LINES"
    if settings.scene_range and frames[0] is not None:
        recipe.frames = f"{scene.frame_start}-{scene.frame_end}"
        frames = [frame for frame in frames if scene.frame_start <= frame <= scene.frame_end]
        if not frames:
            raise SequenceError(f"{velocity}: no frame of {recipe.frames} is there; change the scene's frame range")
    if settings.mask:
        first = velocity % frames[0] if frames[0] is not None else velocity
        options, warning = mask_of(context, settings.mask, first, domain, folder)
        recipe.mask, recipe.box = options.get("mask", ""), options.get("box", ())
        warnings += [warning] if warning else []
    if settings.motion_blur and not recipe.layer:
        recipe.derived = ("velocity",)
    if frames[0] is None:
        recipe.further = ("--steady-frames", "1")
    return recipe, len(frames), warnings


def job_of(settings):
    """The run in the folder of the settings, or None."""
    try:
        job = Job(absolute(settings.folder))
    except ValueError:
        return None
    return job if job.is_known else None


def show_result(context, settings, job):
    """Put the textures of a finished run into the scene, once. Returns warnings. Raises one of ERRORS."""
    if settings.shown == job.output or not job.finished:
        return []
    domain = settings.domain if settings.source == "DOMAIN" else None
    earlier = next((thing for thing in context.scene.objects if thing.get(MADE) == job.output), None)
    if job.layer:
        matrix = placement(read_header(job.finished[0]), domain=domain, lines=True) if domain else None
        thing, _, warnings = import_lines(context, job.layer, settings.look, matrix, earlier, domain)
        prepare_render(context, [])
    else:
        thing, header, _, warnings = import_volume(context, job.finished[0], domain=domain, again=earlier)
        warnings += show(context, thing, header, look=settings.look)
        prepare_render(context, [thing])
        if header.velocity:
            context.scene.render.use_motion_blur = True
    thing[MADE] = job.output
    select_only(context, thing)
    settings.shown = job.output
    return warnings


def watch():
    """Look at the runs of all scenes; called by a timer while one goes on."""
    running = False
    for scene in bpy.data.scenes:
        settings = scene.vdblic
        job = job_of(settings)
        if job is None or settings.shown == job.output:
            continue
        state = job.state
        running = running or state == RUNNING
        if state == DONE and scene == bpy.context.scene:
            try:
                _problems[:] = show_result(bpy.context, settings, job)
            except ERRORS as error:
                _problems[:] = [str(error)]
                settings.shown = job.output
        elif state == FAILED:
            _problems[:] = [job.message]
    for screen in bpy.data.screens:
        for area in screen.areas:
            area.tag_redraw()
    return INTERVAL if running else None


def start_watching(*_):
    if not bpy.app.background and not bpy.app.timers.is_registered(watch):
        bpy.app.timers.register(watch, first_interval=INTERVAL, persistent=True)


class _Operator:
    def refuse(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def warn(self, warnings):
        for warning in warnings:
            self.report({"WARNING"}, warning)
        return {"FINISHED"}


class VDBLIC_OT_estimate(_Operator, bpy.types.Operator):
    """Tell the memory and the time that the texture will take"""

    bl_idname = "vdblic.estimate"
    bl_label = "Estimate"

    def execute(self, context):
        settings = context.scene.vdblic
        try:
            recipe, _, warnings = recipe_of(context, settings)
            found = estimate(recipe, tools_folder())
        except ERRORS as error:
            return self.refuse(error)
        settings.estimate = str(found)
        self.report({"INFO"}, str(found))
        return self.warn(warnings)


class VDBLIC_OT_make(_Operator, bpy.types.Operator):
    """Compute the texture in the background; goes on where an earlier run in the folder ended"""

    bl_idname = "vdblic.make"
    bl_label = "Make Flow Texture"

    wait: BoolProperty(
        name="Wait",
        description="Return when the textures stand in the scene, as scripts need it",
        options={"SKIP_SAVE"},
    )

    def execute(self, context):
        settings = context.scene.vdblic
        _problems.clear()
        try:
            check_tools(tools_folder())
            recipe, count, warnings = recipe_of(context, settings)
            commands = [[find_tool("vdblic_advect", tools_folder()), *recipe.command()]]
            if recipe.layer:
                commands.append([find_tool("vdblic_export", tools_folder()), *recipe.export()])
            job = Job.start(recipe.folder, commands, count, recipe.output, recipe.layer)
            settings.shown = ""
            if self.wait:
                while job.state == RUNNING:
                    time.sleep(0.1)
                if job.state != DONE:
                    return self.refuse(job.message if job.state == FAILED else f"{job.log}: the run was stopped")
                warnings += show_result(context, settings, job)
        except ERRORS as error:
            return self.refuse(error)
        start_watching()
        return self.warn(warnings)


class VDBLIC_OT_cancel(_Operator, bpy.types.Operator):
    """Stop the run; it leaves a checkpoint, from which Make Flow Texture goes on"""

    bl_idname = "vdblic.cancel"
    bl_label = "Cancel"

    def execute(self, context):
        job = job_of(context.scene.vdblic)
        if job is None or job.state != RUNNING:
            return self.refuse("no run is going on in the folder of the textures")
        job.cancel()
        return {"FINISHED"}


class VDBLIC_OT_collect(_Operator, bpy.types.Operator):
    """Put the textures of a finished run into the scene"""

    bl_idname = "vdblic.collect"
    bl_label = "Show Result"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        settings = context.scene.vdblic
        job = job_of(settings)
        if job is None:
            return self.refuse(f"{settings.folder}: there is no run; make a texture first")
        if job.state in (FAILED, RUNNING):
            return self.refuse(job.message if job.state == FAILED else f"{job.folder}: the run is still going on")
        if not job.finished:
            return self.refuse(f"{job.folder}: the run was stopped before its first texture; make it again")
        settings.shown = ""
        try:
            return self.warn(show_result(context, settings, job))
        except ERRORS as error:
            return self.refuse(error)


class VDBLIC_OT_log(_Operator, bpy.types.Operator):
    """Open the log of the run as a text"""

    bl_idname = "vdblic.log"
    bl_label = "Log"

    def execute(self, context):
        job = job_of(context.scene.vdblic)
        if job is None or not job.log.is_file():
            return self.refuse("there is no log; make a texture first")
        text = bpy.data.texts.get("vdblic.log") or bpy.data.texts.new("vdblic.log")
        text.clear()
        text.write(job.command + "\n\n" + job.log.read_text(encoding="utf-8", errors="replace"))
        return {"FINISHED"}


def problems():
    return list(_problems)


CLASSES = [VDBLIC_Settings, VDBLIC_OT_estimate, VDBLIC_OT_make, VDBLIC_OT_cancel, VDBLIC_OT_collect, VDBLIC_OT_log]
