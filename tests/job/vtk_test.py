"""Meshes that VTK writes in every form of .vtp and .vtk are read as VTK has them; each file cut short is refused.

usage: vtk_test.py VRDA
exit: 0 all is well, 1 a finding (printed)
"""
import collections
import itertools
import pathlib
import subprocess
import sys
import tempfile

import vtk


def check(condition, why):
    if not condition:
        print("wrong: " + why)
        sys.exit(1)


def convert(program, file, output):
    return subprocess.run([program, "convert", "mesh", str(file), str(output)], capture_output=True, text=True, check=False)


def turned(face):
    """The face from its smallest corner on; text has six digits of a float."""
    face = [tuple(round(x, 4) + 0.0 for x in p) for p in face]
    first = face.index(min(face))
    return tuple(face[first:] + face[:first])


def faces_of_vtk(data, as_triangles):
    if as_triangles:
        triangles = vtk.vtkTriangleFilter()
        triangles.SetInputData(data)
        triangles.PassLinesOff()
        triangles.PassVertsOff()
        triangles.Update()
        data = triangles.GetOutput()
    faces = collections.Counter()
    for cell in range(data.GetNumberOfCells()):
        ids = data.GetCell(cell).GetPointIds()
        if ids.GetNumberOfIds() > 2:
            faces[turned([data.GetPoint(ids.GetId(k)) for k in range(ids.GetNumberOfIds())])] += 1
    return faces


def faces_of_vf(file):
    words = file.read_text().split()
    n_points, n_faces = int(words[0]), int(words[1])
    points = [tuple(float(w) for w in words[2 + 3 * k:5 + 3 * k]) for k in range(n_points)]
    at, faces = 2 + 3 * n_points, collections.Counter()
    for _ in range(n_faces):
        n = int(words[at])
        faces[turned([points[int(w)] for w in words[at + 1:at + 1 + n]])] += 1
        at += 1 + n
    return faces


def surfaces():
    """A ball of triangles, a cube of squares in doubles, both in one with lines, and strips; with arrays that are not read."""
    ball = vtk.vtkSphereSource()
    ball.SetRadius(10)
    ball.Update()
    cube = vtk.vtkCubeSource()
    cube.SetCenter(0.1, 20, 0)
    cube.SetOutputPointsPrecision(vtk.vtkAlgorithm.DOUBLE_PRECISION)
    cube.Update()
    line = vtk.vtkLineSource()
    both = vtk.vtkAppendPolyData()
    for part in (ball, line, cube):
        both.AddInputConnection(part.GetOutputPort())
    both.Update()
    strips = vtk.vtkStripper()
    strips.SetInputData(ball.GetOutput())
    strips.Update()
    for name, source in (("ball", ball), ("cube", cube), ("both", both), ("strips", strips)):
        data = vtk.vtkPolyData()
        data.DeepCopy(source.GetOutput())
        texts, bits = vtk.vtkStringArray(), vtk.vtkBitArray()
        texts.SetName("texts")
        bits.SetName("bits")
        for word in ("short", "long " * 40):
            texts.InsertNextValue(word)
            bits.InsertNextValue(1)
        data.GetFieldData().AddArray(texts)
        data.GetFieldData().AddArray(bits)
        yield name, data


def write_xml(folder, name, data):
    forms = itertools.product(("Ascii", "Binary", "Appended"), ("ZLib", "None"), ("LittleEndian", "BigEndian"),
                              ("UInt32", "UInt64"), (False, True))
    for mode, compressor, order, header, is_base64 in forms:
        if is_base64 and mode != "Appended":
            continue
        writer = vtk.vtkXMLPolyDataWriter()
        writer.SetInputData(data)
        getattr(writer, "SetDataModeTo" + mode)()
        getattr(writer, "SetCompressorTypeTo" + compressor)()
        getattr(writer, "SetByteOrderTo" + order)()
        getattr(writer, "SetHeaderTypeTo" + header)()
        writer.SetIdType(vtk.vtkXMLWriter.Int32 if header == "UInt32" else vtk.vtkXMLWriter.Int64)
        writer.SetEncodeAppendedData(is_base64)
        writer.SetBlockSize(256)  # several blocks
        writer.SetNumberOfPieces(2 if name == "ball" else 1)
        path = folder / f"{name}_{mode}_{compressor}_{order}_{header}_{is_base64}.vtp"
        writer.SetFileName(str(path))
        writer.Write()
        yield path


def write_legacy(folder, name, data):
    for kind, version in itertools.product((vtk.VTK_ASCII, vtk.VTK_BINARY), (42, 51)):
        writer = vtk.vtkPolyDataWriter()
        writer.SetInputData(data)
        writer.SetFileType(kind)
        writer.SetFileVersion(version)
        path = folder / f"{name}_{kind}_{version}.vtk"
        writer.SetFileName(str(path))
        writer.Write()
        yield path


def main(program):
    n_read = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        out = folder / "out.vf"
        for name, data in surfaces():
            for path in itertools.chain(write_xml(folder, name, data), write_legacy(folder, name, data)):
                done = convert(program, path, out)
                check(done.returncode == 0, f"{path.name}: {done.stderr}")
                reader = vtk.vtkXMLPolyDataReader() if path.suffix == ".vtp" else vtk.vtkPolyDataReader()
                reader.SetFileName(str(path))
                reader.Update()
                wanted = faces_of_vtk(reader.GetOutput(), name == "strips")
                check(sum(wanted.values()) > 5 and faces_of_vf(out) == wanted, f"{path.name}: other faces")
                n_read += 1
                cut = folder / ("cut" + path.suffix)
                whole = path.read_bytes()
                for share in (0.3, 0.5, 0.6) if n_read % 5 == 0 else ():
                    cut.write_bytes(whole[:int(share * len(whole))])
                    done = convert(program, cut, out)
                    check(done.returncode == 2 and done.stderr.count("\n") == 1, f"{path.name} cut to {share}: {done.stderr}")
    check(n_read == 4 * (32 + 4), f"{n_read} files were read")


if __name__ == "__main__":
    main(sys.argv[1])
