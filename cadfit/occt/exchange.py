"""STEP and BREP files."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeAlias

from OCP.BRep import BRep_Builder
from OCP.BRepTools import BRepTools
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Controller, IGESControl_Reader, IGESControl_Writer
from OCP.IGESData import IGESData_IGESWriter
from OCP.IGESSelect import IGESSelect_WorkLibrary
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.STEPControl import (
    STEPControl_Controller,
    STEPControl_Reader,
    STEPControl_StepModelType,
    STEPControl_Writer,
)
from OCP.StepData import StepData_StepModel, StepData_StepWriter
from OCP.StepGeom import StepGeom_BSplineCurveWithKnots, StepGeom_TrimmedCurve
from OCP.StepVisual import StepVisual_LayeredItem, StepVisual_PresentationLayerAssignment
from OCP.TCollection import TCollection_HAsciiString
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shape

from cadfit.bspline import BSpline
from cadfit.occt.kernel import PASSES_BACKSLASHES, KernelError, LayeredItems, building
from cadfit.occt.shapes import to_edge
from cadfit.replacing import replacing

UNITS = {"um": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1e3, "km": 1e6, "inch": 25.4, "ft": 304.8}
"""The length units of a STEP file, in millimetres."""

PathLike: TypeAlias = str | os.PathLike[str]
Writable: TypeAlias = BSpline | TopoDS_Shape | Iterable[BSpline | TopoDS_Shape]


def write_step(path: PathLike, shapes: Writable, unit: str = "mm", names: Sequence[str] = ()) -> None:
    """Write splines (as edges) and kernel shapes to a STEP file whose unit of length is `unit`, one of `UNITS`.

    The numbers are written as they are, to 17 digits: 1.0 with unit="m" is one metre to whoever reads the file, and
    poles and knots are read back bit for bit. Edges and wires alone become a GEOMETRIC_CURVE_SET, where CAM programs
    look for wires; `names`, one for each B-spline curve, become those of the curves and, from OCP 7.9 on, of the layers
    they lie on; an empty one is none. The file is replaced at once or, on failure, left as it was. Raises ValueError
    for an unknown unit, no shapes and other than as many names, KernelError, and OSError naming the path.
    """
    found = _shapes(shapes)
    with _step(f"a STEP file of {len(found)} shape(s)", unit) as millimetres:
        writer = STEPControl_Writer()
        model = writer.Model(True)
        model.SetLocalLengthUnit(millimetres)
        model.SetWriteLengthUnit(millimetres)  # the same: the numbers are not scaled
        for shape in found:
            status = writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
            if status != IFSelect_ReturnStatus.IFSelect_RetDone:
                raise KernelError(status.name)
        if names:
            _name(model, names)
        text = StepData_StepWriter(model)
        text.FloatWriter().SetFormat("%.16E")  # the kernel's own 13 digits lose small features far from the origin
        text.SendModel(writer.WS().Protocol())
        stream = io.BytesIO()
        if not text.Print(stream):
            raise KernelError("the text could not be made")
    with replacing(Path(path)) as beside:
        beside.write_bytes(stream.getvalue())


def _name(model: StepData_StepModel, names: Sequence[str]) -> None:
    """Give names to a model's B-spline curves, in order, and put each on the layer of its name."""
    entities = [model.Value(k) for k in range(1, model.NbEntities() + 1)]
    curves = [each for each in entities if isinstance(each, StepGeom_BSplineCurveWithKnots)]
    if len(curves) != len(names):
        raise ValueError(f"{len(curves)} B-spline curves need as many names, not {len(names)}")
    layers: dict[str, list[StepGeom_TrimmedCurve]] = {}
    named = dict(zip(map(id, curves), names, strict=True))
    for each in entities:
        if isinstance(each, StepGeom_TrimmedCurve) and (name := named.get(id(each.BasisCurve()))):
            layers.setdefault(name, []).append(each)
    for curve, name in zip(curves, names, strict=True):
        curve.SetName(_text(name))
    for name, held in layers.items():
        items = LayeredItems(1, len(held))
        for k, each in enumerate(held, 1):
            item = StepVisual_LayeredItem()
            item.SetValue(each)
            items.SetValue(k, item)
        layer = StepVisual_PresentationLayerAssignment()
        layer.Init(_text(name), _text(""), items)
        model.AddWithRefs(layer)


def _text(text: str) -> TCollection_HAsciiString:
    """Return a text for STEP, whose strings are ASCII: other letters by their numbers. Source: ISO 10303-21, 6.4.3.

    A kernel that doubles backslashes gets the letters themselves: their numbers would come back as text.
    """

    def numbered(run: re.Match[str]) -> str:
        wide = max(run.group()) > "\uffff"
        code = run.group().encode("utf-32-be" if wide else "utf-16-be").hex().upper()
        return f"\\X{4 if wide else 2}\\{code}\\X0\\"

    return TCollection_HAsciiString(re.sub(r"[^\x00-\x7f]+", numbered, text) if PASSES_BACKSLASHES else text)


def write_iges(path: PathLike, shapes: Writable) -> None:
    """Write splines (as entity 126, with 17 digits) and kernel shapes to an IGES file in millimetres.

    Replaces the file and raises as `write_step`.
    """
    found = _shapes(shapes)
    with _step(f"an IGES file of {len(found)} shape(s)", "mm"):
        IGESControl_Controller.Init_s()
        writer = IGESControl_Writer("MM", 0)
        for shape in found:
            if not writer.AddShape(shape):
                raise KernelError("a shape that IGES cannot hold")
        writer.ComputeModel()
        text = IGESData_IGESWriter(writer.Model())
        text.FloatWriter().SetFormat("%.16E")
        text.SendModel(IGESSelect_WorkLibrary.DefineProtocol_s())
        stream = io.BytesIO()
        if not text.Print(stream):
            raise KernelError("the text could not be made")
    with replacing(Path(path)) as beside:
        beside.write_bytes(stream.getvalue())


def read_iges(path: PathLike) -> TopoDS_Shape:
    """Return the shapes of an IGES file in one, in millimetres whatever the file's unit is; `edges` finds its curves.

    Raises OSError when the file cannot be read, ValueError when it is not IGES, is cut short or holds no shape.
    """
    data = Path(path).read_bytes()
    if len(data) < 80 or data[72:73] not in (b"S", b"F"):  # the kernel would print that it is no IGES file
        raise ValueError(f"{path}: not an IGES file")
    if not any(line[72:73] == b"T" for line in data.splitlines()):  # the kernel would take what is missing for zeros
        raise ValueError(f"{path}: an IGES file that is cut short: it has no terminate section")
    with _step(f"the shapes of {path}", "mm"):
        IGESControl_Controller.Init_s()
        reader = IGESControl_Reader()
        if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise ValueError(f"{path}: not an IGES file")
        reader.TransferRoots()
        shape = reader.OneShape()
    if shape.IsNull():
        raise ValueError(f"{path}: no shape in this IGES file")
    return shape


def read_step(path: PathLike, unit: str = "mm") -> tuple[TopoDS_Shape, ...]:
    """Return the shapes of a STEP file, their numbers in `unit` whatever the file's own unit is.

    One shape for each that was written (the kernel writes a loose edge in its curve's own direction); `edges` finds
    the curves in them. Raises OSError when the file cannot be read, ValueError for an unknown unit and where the file
    is not STEP or holds no shape.
    """
    content = Path(path).read_bytes()
    with _step(f"the shapes of {path}", unit) as millimetres:
        reader = STEPControl_Reader()
        if reader.ReadStream(Path(path).name, io.BytesIO(content)) != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise ValueError(f"{path}: not a STEP file")
        reader.SetSystemLengthUnit(millimetres)  # of the model just read: earlier there is none to take it
        reader.TransferRoots()
        found = tuple(reader.Shape(k) for k in range(1, reader.NbShapes() + 1))
    if not found:
        raise ValueError(f"{path}: no shape in this STEP file")
    return found


def write_brep(path: PathLike, shapes: Writable) -> None:
    """Write splines (as edges) and kernel shapes to a BREP file, the kernel's own text form, as one compound.

    The file knows no unit; its numbers have the kernel's 15 digits. Replaces the file and raises as `write_step`.
    """
    found = _shapes(shapes)
    builder, compound, stream = BRep_Builder(), TopoDS_Compound(), io.BytesIO()
    with building(f"a BREP file of {len(found)} shape(s)"):
        builder.MakeCompound(compound)
        for shape in found:
            builder.Add(compound, shape)
        BRepTools.Write_s(compound, stream)
    with replacing(Path(path)) as beside:
        beside.write_bytes(stream.getvalue())


def read_brep(path: PathLike) -> TopoDS_Shape:
    """Return the shape in a BREP file (a compound, where `write_brep` made it); `edges` finds its curves.

    Raises OSError when the file cannot be read, ValueError when it is not a BREP file.
    """
    content = Path(path).read_bytes()
    shape = TopoDS_Shape()
    if b"CASCADE Topology V" in content:  # the kernel would print that it is missing
        with building(f"the shape of {path}"):
            BRepTools.Read_s(shape, io.BytesIO(content), BRep_Builder())
    if shape.IsNull():
        raise ValueError(f"{path}: not a BREP file")
    return shape


def _shapes(shapes: Writable) -> list[TopoDS_Shape]:
    """Return one or more splines and shapes as a list of shapes."""
    given = [shapes] if isinstance(shapes, BSpline | TopoDS_Shape) else shapes
    found = [to_edge(shape) if isinstance(shape, BSpline) else shape for shape in given]
    for shape in found:
        if not isinstance(shape, TopoDS_Shape) or shape.IsNull():
            raise ValueError(f"a BSpline or a TopoDS_Shape that is not null can be written, not {shape!r}")
    if not found:
        raise ValueError("there are no shapes to write")
    return found


@contextmanager
def _step(what: str, unit: str) -> Iterator[float]:
    """Name what is built, give the unit in mm, and meanwhile have the kernel write that unit and print nothing.

    Unit and printers are global in the kernel; both are put back.
    """
    if unit not in UNITS:
        raise ValueError(f"the unit must be one of {', '.join(UNITS)}, not {unit!r}")
    STEPControl_Controller.Init_s()
    messenger, before = Message.DefaultMessenger_s(), Interface_Static.CVal_s("write.step.unit")
    printers = [*messenger.Printers()]
    for printer in printers:
        messenger.RemovePrinter(printer)
    Interface_Static.SetCVal_s("write.step.unit", unit.upper())
    try:
        with building(what):
            yield UNITS[unit]
    finally:
        Interface_Static.SetCVal_s("write.step.unit", before)
        for printer in printers:
            messenger.AddPrinter(printer)
