"""STEP files of whole members: B-spline surfaces through the points of the cutting simulation, sewn to a closed solid.

One pitch consists of patches on the grid of the tooth: flanks, fillets, top land, root, end faces, body. The others are
rotated copies. Adjacent patches share points and parameters along their edge, and therefore the same curve. The kernel
is Open CASCADE, the extra ``cad``.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from efficiency.contact.assembly import Assembly
from efficiency.contact.gear_flanks import Member
from efficiency.contact.tooth_grid import ToothGrid
from efficiency.output.solid import body_section, ring_points
from ehl.common.arrays import FloatArray
from ehl.common.errors import ConvergenceError, InputError
from ehl.common.files import make_folder

TOLERANCE = 1e-4  # largest distance of joined edges [mm]
_ACROSS = 7  # points across a top land, a root, a part of the body
_MM = 1e3


@dataclass(frozen=True)
class _Surface:
    """Control points (a, b, 3) [mm] and knots of a B-spline surface."""

    control: FloatArray
    knots: tuple[FloatArray, FloatArray]
    degrees: tuple[int, int]


def _surface(points: FloatArray, rows: FloatArray | None = None) -> _Surface:
    """Surface through points (a, b, 3) [m]; parameters equally spaced, those along a given by `rows`."""
    count = points.shape[:2]
    at = [np.linspace(0.0, 1.0, n) for n in count]
    if rows is not None:
        at[0] = rows
    degrees = min(3, count[0] - 1), min(3, count[1] - 1)
    first = make_interp_spline(at[0], points * _MM, k=degrees[0], axis=0)
    second = make_interp_spline(at[1], np.moveaxis(first.c, 1, 0), k=degrees[1], axis=0)
    return _Surface(np.moveaxis(second.c, 0, 1), (first.t, second.t), degrees)


def member_patches(grid: ToothGrid, rim: float | None, bore: float | None) -> tuple[list[_Surface], list[FloatArray]]:
    """Surfaces of one pitch, and, without bore, the rings of points (a, 3) [m] that bound the plane faces."""
    radii, planes, hole = body_section(grid, rim, bore)
    u, h = grid.u, grid.height
    rows = len(h)
    low = max(2, rows // 3) if any(grid.fillets) else 0
    lower, upper = grid.point(grid.lower, u, h), grid.point(grid.upper, u, h)
    found: list[_Surface] = []
    share = np.linspace(0.0, 1.0, _ACROSS)[:, None]
    for start, stop in ((0, low), (low, rows - 1)):
        if start == stop:
            continue
        part = slice(start, stop + 1)
        steps = sum(np.linalg.norm(np.diff(flank[part], axis=0), axis=-1) for flank in (lower, upper))
        along = np.concatenate([[0.0], np.cumsum(steps.mean(axis=1))])
        along /= along[-1]
        found += [_surface(flank[part], along) for flank in (lower, upper)]
        for column in (0, -1):
            azimuth = (1.0 - share) * grid.lower[part, column] + share * grid.upper[part, column]
            face = grid.point(azimuth, u[part, column], h[part, column])
            found.append(_surface(np.moveaxis(face, 0, 1), along))
    following = grid.lower[0] + grid.pitch
    land = (1.0 - share) * grid.lower[-1] + share * grid.upper[-1]
    root = (1.0 - share) * grid.upper[0] + share * following
    found += [_surface(grid.point(land, u[-1], h[-1])), _surface(grid.point(root, u[0], h[0]))]

    rings: list[FloatArray] = []
    turn = grid.pitch * round(float(grid.lower[0, -1] - grid.lower[0, 0]) / grid.pitch)
    for begin, end in ((grid.lower[0], grid.upper[0]), (grid.upper[0], following)):
        toe, heel = (((1.0 - share[:, 0]) * begin[c] + share[:, 0] * end[c]) for c in (0, -1))
        for azimuth, column, radius, z in ((toe, 0, radii[0], planes[0]), (heel, -1, radii[1], planes[1])):
            outer = grid.point(azimuth, u[0, column], h[0, column])
            edge = ring_points(azimuth, radius, z)
            found.append(_surface(np.stack([outer, edge])))
            if hole == 0.0:
                rings.append(edge)
                continue
            # the bore is divided at the azimuths of the toe
            inner = toe if column == 0 else toe + turn
            found.append(_surface(np.stack([edge, ring_points(inner, 0.5 * hole, z)])))
        if hole > 0.0:
            found.append(_surface(np.stack([ring_points(toe, 0.5 * hole, z) for z in planes])))
    return found, rings


def write_step(path: Path, grid: ToothGrid, title: str, rim: float | None = None, bore: float | None = None) -> float:
    """Write a whole member as STEP (mm); returns the volume of the solid [m3].

    path: file to write.
    grid: flanks of the member.
    title: name of the product.
    rim, bore: as in `efficiency.output.solid.member_solid`.
    Raises `InputError` if Open CASCADE is not installed, rim or bore do not fit, or the file cannot be written;
    `ConvergenceError` if the faces are not closed.
    """
    solid = member_shape(grid, rim, bore)
    write_shapes(path, [solid], title)
    return shape_volume(solid)


def write_shapes(path: Path, shapes: Iterable[Any], title: str) -> None:
    """Write shapes of Open CASCADE as the parts of one STEP file (mm)."""
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    make_folder(path.parent, "output")
    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    Interface_Static.SetCVal_s("write.step.product.name", title)
    for shape in shapes:
        writer.Transfer(shape, STEPControl_AsIs)
    if writer.Write(str(path)) != IFSelect_RetDone:
        raise InputError("output", str(path), "a writable file")


def placed_in_mesh(shape: Any, grid: ToothGrid, assembly: Assembly, member: Member) -> Any:
    """A member (mm) in the mesh frame at zero rotation, where a tooth of the pinion is in a slot of the gear."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf

    origin = in_mesh(np.zeros((3, 1)), grid, assembly, member)
    matrix = np.hstack([in_mesh(np.eye(3), grid, assembly, member) - origin, origin * _MM])
    place = gp_Trsf()
    place.SetValues(*(float(x) for x in matrix.ravel()))
    return BRepBuilderAPI_Transform(shape, place, True).Shape()


def in_mesh(points: FloatArray, grid: ToothGrid, assembly: Assembly, member: Member) -> FloatArray:
    """Points (3, n) of a member, in the frame of its grid, in the mesh frame at zero rotation [m]."""
    turned = np.full(points.shape[1], grid.middle)
    return assembly.pinion_in_mesh(points, turned) if member == "pinion" else assembly.gear_in_mesh(points, turned)


def read_step(path: Path) -> Any:
    """The shape of a STEP file in Open CASCADE [mm]."""
    require_kernel()
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise InputError("file", str(path), "a STEP file")
    reader.TransferRoots()
    return reader.OneShape()


def shape_volume(shape: Any) -> float:
    """Volume of a shape given in mm [m3]."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass()) * 1e-9


def require_kernel() -> None:
    """Silence the messages of Open CASCADE; an `InputError` names the extra if it is not installed."""
    try:
        from OCP.Message import Message
        from OCP.TColgp import TColgp_Array2OfPnt  # noqa: F401
    except ImportError:
        hint = "Install it with: pip install 'mixed-ehl[cad]'. STL export works without it."
        raise InputError("what", "step", "tooth, member, grid, summary without Open CASCADE", hint) from None
    printers = Message.DefaultMessenger_s().ChangePrinters()
    printers.Clear()


def member_shape(grid: ToothGrid, rim: float | None = None, bore: float | None = None) -> Any:
    """The closed solid of a whole member for Open CASCADE [mm]."""
    require_kernel()
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_SHELL
    from OCP.TopoDS import TopoDS

    surfaces, rings = member_patches(grid, rim, bore)
    sewing = BRepBuilderAPI_Sewing(TOLERANCE)
    turned = []
    for tooth in range(grid.blank.teeth):
        angle = tooth * grid.pitch
        turn = np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
        for surface in surfaces:
            sewing.Add(_face(surface, turn))
        turned.append([ring @ turn for ring in rings])
    if rings:
        for end in (0, 1):
            sewing.Add(_plane([ring for tooth in turned for ring in tooth[end::2]]))
    sewing.Perform()
    shell = sewing.SewedShape()
    if (count := sewing.NbFreeEdges()) or shell.ShapeType() != TopAbs_SHELL:
        raise ConvergenceError("open_solid", f"{count} edges of the faces are not joined: change rows or columns")
    solid = BRepBuilderAPI_MakeSolid(TopoDS.Shell_s(shell)).Solid()
    if shape_volume(solid) < 0.0:
        solid.Reverse()
    if not BRepCheck_Analyzer(solid).IsValid():
        raise ConvergenceError("open_solid", "Open CASCADE rejects the solid as invalid: change rows or columns")
    return solid


def _face(surface: _Surface, turn: FloatArray) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.Geom import Geom_BSplineSurface
    from OCP.gp import gp_Pnt
    from OCP.TColgp import TColgp_Array2OfPnt

    control = surface.control @ turn
    poles = TColgp_Array2OfPnt(1, control.shape[0], 1, control.shape[1])
    points: Any = control.reshape(-1, 3).tolist()
    for (i, j), point in zip(np.ndindex(control.shape[:2]), points, strict=True):
        poles.SetValue(i + 1, j + 1, gp_Pnt(*point))
    (a, m), (b, n) = (_knots(t) for t in surface.knots)
    return BRepBuilderAPI_MakeFace(Geom_BSplineSurface(poles, a, b, m, n, *surface.degrees), 1e-7).Face()


def _knots(vector: FloatArray) -> tuple[Any, Any]:
    from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal

    values, counts = np.unique(vector, return_counts=True)
    knots, multiplicity = TColStd_Array1OfReal(1, len(values)), TColStd_Array1OfInteger(1, len(values))
    for i, (value, count) in enumerate(zip(values, counts, strict=True), 1):
        knots.SetValue(i, float(value))
        multiplicity.SetValue(i, int(count))
    return knots, multiplicity


def _plane(rings: list[FloatArray]) -> Any:
    """Plane face inside consecutive arcs."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt
    from OCP.TColgp import TColgp_Array1OfPnt

    wire = BRepBuilderAPI_MakeWire()
    for ring in rings:
        spline = make_interp_spline(np.linspace(0.0, 1.0, len(ring)), ring * _MM, k=3, axis=0)
        poles = TColgp_Array1OfPnt(1, len(spline.c))
        points: Any = spline.c.tolist()
        for i, point in enumerate(points, 1):
            poles.SetValue(i, gp_Pnt(*point))
        wire.Add(BRepBuilderAPI_MakeEdge(Geom_BSplineCurve(poles, *_knots(spline.t), 3)).Edge())
    return BRepBuilderAPI_MakeFace(wire.Wire(), True).Face()
