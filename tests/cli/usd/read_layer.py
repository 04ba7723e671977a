"""Tells what OpenUSD reads from a layer, as JSON, and what its validators, which usdchecker runs, find: for Python
with usd-core.

    python read_layer.py LAYER.usda FRAME...
"""

import json
import sys

from pxr import Gf, Usd, UsdGeom, UsdValidation, UsdVol

path, *frames = sys.argv[1:]
stage = Usd.Stage.Open(path)
volume = UsdVol.Volume(stage.GetPrimAtPath("/flow/volume"))
fields = {name: UsdVol.OpenVDBAsset(stage.GetPrimAtPath(target)) for name, target in volume.GetFieldPaths().items()}


proxy = UsdVol.Volume(stage.GetPrimAtPath("/flow/proxy"))
roles = [UsdGeom.Imageable(one).GetPurposeAttr().Get() for one in (volume, proxy)] if proxy else []
roles += [str(volume.GetPrim().GetRelationship("proxyPrim").GetTargets()[0])] if proxy else []


def at(frame):
    files = {name: field.GetFilePathAttr().Get(frame) for name, field in fields.items()}
    told = {
        "files": {name: file and file.resolvedPath for name, file in files.items()},
        "extent": [list(corner) for corner in volume.GetExtentAttr().Get(frame)],
    }
    cache = UsdGeom.BBoxCache(frame, [UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    box = cache.ComputeWorldBound(volume.GetPrim()).ComputeAlignedRange()
    told["world"] = [list(box.GetMin()), list(box.GetMax())]
    if proxy:
        box = UsdGeom.BBoxCache(frame, [UsdGeom.Tokens.proxy]).ComputeWorldBound(proxy.GetPrim()).ComputeAlignedRange()
        told |= {
            "proxy": UsdVol.OpenVDBAsset(proxy.GetPrim().GetChild("density")).GetFilePathAttr().Get(frame).resolvedPath,
            "proxy_world": [list(box.GetMin()), list(box.GetMax())],
        }
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/flow/camera"))
    if camera:
        lens = camera.GetCamera(frame)
        place = lens.transform
        told["camera"] = {
            "eye": list(place.ExtractTranslation()),
            "forward": list(lens.frustum.ComputeViewDirection()),
            "up": list(lens.frustum.ComputeUpVector()),
            "fov": lens.GetFieldOfView(Gf.Camera.FOVVertical),
            "projection": str(lens.projection),
            "clipping": [lens.clippingRange.min, lens.clippingRange.max],
        }
    return told


found = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators()).Validate(stage)
print(
    json.dumps(
        {
            "errors": [error.GetErrorAsString() for error in found],
            "proxy": roles,
            "default": str(stage.GetDefaultPrim().GetPath()),
            "up": str(UsdGeom.GetStageUpAxis(stage)),
            "meters": UsdGeom.GetStageMetersPerUnit(stage),
            "rate": stage.GetTimeCodesPerSecond(),
            "range": [stage.GetStartTimeCode(), stage.GetEndTimeCode()],
            "fields": {
                name: [
                    str(field.GetFieldNameAttr().Get()),
                    str(field.GetFieldDataTypeAttr().Get()),
                    str(field.GetFieldClassAttr().Get()),
                    str(field.GetVectorDataRoleHintAttr().Get()),
                ]
                for name, field in fields.items()
            },
            "frames": {frame: at(float(frame)) for frame in frames},
        }
    )
)
