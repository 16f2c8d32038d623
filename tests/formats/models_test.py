#!/usr/bin/python3
"""Models and surfaces in every format, against readers and writers that share no code with ours.

Usage: models_test.py IO_MESH_TEST DIR

IO_MESH_TEST is the unit test program of the room anatomesh_io/mesh. It writes model.{vtu,msh,mesh,inp},
surface.{vtp,stl,ply,obj} and truth.txt into DIR; VTK, meshio and Gmsh read them; then VTK and meshio write the
model in other variants of the formats into DIR/foreign, and IO_MESH_TEST reads those.
Covers rows O-01 (points to the last bit, connectivity, labels), O-02 (positive tetrahedra) and O-07 (the frame is
stated) of the catalogue. Exit code 0 when all agree.
"""
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

failures = []


def check(what, condition):
    print(('ok   ' if condition else 'FAIL ') + what)
    if not condition:
        failures.append(what)


def read_truth(path):
    lines = iter(open(path).read().split('\n'))

    def block(kind, rows):
        return np.array([[kind(x) for x in next(lines).split()] for _ in range(rows)])
    n, m = map(int, next(lines).split())
    points, cells = block(float.fromhex, n), block(int, m)
    k, t = map(int, next(lines).split())
    surface_points, triangles = block(float.fromhex, k), block(int, t)
    return points, cells[:, :4], cells[:, 4], surface_points, triangles[:, :3], triangles[:, 3:]


def all_positive(points, cells):
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    return bool((np.einsum('ij,ij->i', np.cross(b - a, c - a), d - a) > 0).all())


def compare_model(what, points, cells, labels, truth):
    check(what + ': points to the last bit', points.shape == truth[0].shape and bool((points == truth[0]).all()))
    check(what + ': connectivity', cells.shape == truth[1].shape and bool((cells == truth[1]).all()))
    check(what + ': labels', labels.shape == truth[2].shape and bool((labels == truth[2]).all()))
    check(what + ': positive', all_positive(points, cells))


def with_vtk(folder, truth):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    errors = []

    def read(reader, name):
        reader.AddObserver('ErrorEvent', lambda *_: errors.append(name))
        reader.SetFileName(os.path.join(folder, name))
        reader.Update()
        check(f'VTK {name}: no error', name not in errors)
        return reader.GetOutput()

    def frame(data, name):
        field = data.GetFieldData()
        text = {k: field.GetAbstractArray(k).GetValue(0) for k in ('SPACE', 'UNIT') if field.GetAbstractArray(k)}
        check(f'VTK {name}: SPACE=LPS, mm', text == {'SPACE': 'LPS', 'UNIT': 'mm'})

    grid = read(vtk.vtkXMLUnstructuredGridReader(), 'model.vtu')
    frame(grid, 'model.vtu')
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    check('VTK model.vtu: cell types', bool((vtk_to_numpy(grid.GetCellTypesArray()) == 10).all()))
    compare_model('VTK model.vtu', vtk_to_numpy(grid.GetPoints().GetData()), cells,
                  vtk_to_numpy(grid.GetCellData().GetArray('structure')), truth)
    check('VTK model.vtu: quality is double', grid.GetCellData().GetArray('quality').GetDataTypeAsString() == 'double')

    readers = {'vtp': vtk.vtkXMLPolyDataReader, 'stl': vtk.vtkSTLReader, 'ply': vtk.vtkPLYReader,
               'obj': vtk.vtkOBJReader}
    for extension, kind in readers.items():
        name = 'surface.' + extension
        data = read(kind(), name)
        points = vtk_to_numpy(data.GetPoints().GetData())
        triangles = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        if extension == 'vtp':
            frame(data, name)
            check(f'VTK {name}: points to the last bit', points.dtype == np.float64 and bool((points == truth[3]).all()))
            got = np.stack([vtk_to_numpy(data.GetCellData().GetArray(a)) for a in ('structure', 'region_in', 'region_out')], 1)
            check(f'VTK {name}: structure and sides', bool((got == truth[5]).all()))
        # VTK holds the other formats in single precision; it merges the corners of STL in its own order.
        corners = points[triangles]
        wanted = truth[3][truth[4]]
        single = corners.astype(np.float32) == wanted.astype(np.float32)
        check(f'VTK {name}: corners', corners.shape == wanted.shape and bool(single.all()))


def with_meshio(folder, truth):
    # Not the .vtu: meshio refuses every file with text in its field data, where SPACE=LPS stands.
    import meshio
    labels = {'model.msh': 'gmsh:physical', 'model.mesh': 'medit:ref', 'model.inp': None}
    for name, label in labels.items():
        mesh = meshio.read(os.path.join(folder, name))
        blocks = [(b.data, i) for i, b in enumerate(mesh.cells) if b.type == 'tetra']
        cells = np.vstack([b for b, _ in blocks])
        if label:
            values = np.concatenate([np.asarray(mesh.cell_data[label][i]) for _, i in blocks])
        else:  # Abaqus: sets of elements per structure or region, checked by their sizes below
            values = None
        points = np.asarray(mesh.points, float)
        if values is None:
            compare_as_sets('meshio ' + name, points, cells, truth)
        elif name == 'model.msh':  # by region: put into the order of the truth
            order, wanted = sort_cells(cells), sort_cells(truth[1])
            compare_model('meshio ' + name, points, cells[order], values[order],
                          (truth[0], truth[1][wanted], truth[2][wanted]))
        else:
            compare_model('meshio ' + name, points, cells, values, truth)
    # Not the .ply: meshio misreads faces that have properties beside their vertices.
    for name in ('surface.obj', 'surface.stl'):
        mesh = meshio.read(os.path.join(folder, name))
        triangles = np.vstack([b.data for b in mesh.cells if b.type == 'triangle'])
        corners, wanted = np.asarray(mesh.points, float)[triangles], truth[3][truth[4]]
        if name == 'surface.stl':
            wanted = wanted.astype(np.float32)
        check(f'meshio {name}: corners', corners.shape == wanted.shape and bool((corners == wanted).all()))
        if name == 'surface.obj':
            check(f'meshio {name}: points to the last bit, triangles',
                  bool((mesh.points == truth[3]).all() and (triangles == truth[4]).all()))


def sort_cells(cells):
    return np.lexsort(cells.T[::-1])


def compare_as_sets(what, points, cells, truth):
    check(what + ': points to the last bit', points.shape == truth[0].shape and bool((points == truth[0]).all()))
    check(what + ': cells', cells.shape == truth[1].shape and
          bool((cells[sort_cells(cells)] == truth[1][sort_cells(truth[1])]).all()))
    check(what + ': positive', all_positive(points, cells))


def with_gmsh(folder, truth):
    """Gmsh itself reads .msh and .mesh and writes them anew; meshio reads what it wrote."""
    import meshio
    from scipy.spatial import cKDTree
    program = shutil.which('gmsh')
    if not program:
        check('gmsh is installed', False)
        return
    with tempfile.TemporaryDirectory() as out:
        for name in ('model.msh', 'model.mesh'):
            written = os.path.join(out, name + '.mesh')
            run = subprocess.run([program, os.path.join(folder, name), '-save', '-format', 'mesh', '-o', written,
                                  '-save_all', '-v', '3'], capture_output=True, text=True)
            text = run.stdout + run.stderr
            good = run.returncode == 0 and 'Error' not in text and 'Warning' not in text and os.path.exists(written)
            check(f'Gmsh {name}: reads without a warning', good)
            if not good:
                print(text[-2000:])
                continue
            mesh = meshio.read(written)
            cells = np.vstack([b.data for b in mesh.cells if b.type == 'tetra'])
            # Gmsh numbers the vertices anew and writes 14 digits: each is taken for the nearest true one.
            distance, vertex = cKDTree(truth[0]).query(mesh.points)
            cells, wanted = np.sort(vertex[cells], 1), np.sort(truth[1], 1)
            check(f'Gmsh {name}: points', len(set(vertex)) == len(truth[0]) and distance.max() < 1e-9)
            check(f'Gmsh {name}: cells', cells.shape == wanted.shape and
                  bool((cells[sort_cells(cells)] == wanted[sort_cells(wanted)]).all()))


def with_own_abaqus(folder, truth):
    """The element sets and node order of the .inp by a parser of a few lines."""
    text = open(os.path.join(folder, 'model.inp'), encoding='utf-8').read()
    check('model.inp: states its frame', '** SPACE=LPS\n** UNIT=mm\n' in text)
    region_of, sets, node_sets, surfaces, current = {}, {}, {}, {}, None
    for line in text.split('\n'):
        if line.startswith('**') or not line:
            continue
        if line.startswith('*'):
            keyword, *options = [p.strip() for p in line.split(',')]
            current = (keyword, dict(o.split('=') for o in options if '=' in o))
        elif current[0] == '*ELEMENT':
            element, *nodes = [int(x) for x in line.split(',')]
            region_of[element] = current[1]['ELSET']
            if [x - 1 for x in nodes] != list(truth[1][element - 1]):
                check(f'model.inp: element {element}', False)
        elif current[0] == '*ELSET':
            sets.setdefault(current[1]['ELSET'], []).append(line.strip())
        elif current[0] == '*NSET':
            node_sets.setdefault(current[1]['NSET'], []).extend(int(x) - 1 for x in line.split(',') if x.strip())
        elif current[0] == '*SURFACE':
            surfaces.setdefault(current[1]['NAME'], []).append(line)
    check('model.inp: every element in a region', len(region_of) == len(truth[1]))
    of_structure = {'STRUCTURE_5': ['REGION_1', 'REGION_2'], 'STRUCTURE_7': ['REGION_2'], 'STRUCTURE_300': ['REGION_3']}
    check('model.inp: a set per structure', {k: v for k, v in sets.items() if k.startswith('STRUCTURE')} == of_structure)
    label_regions = {5: 'REGION_1', 301: 'REGION_2', 300: 'REGION_3'}
    region_of_cell = np.array([label_regions[n] for n in truth[2]])
    for name, regions in of_structure.items():
        nodes = np.unique(truth[1][np.isin(region_of_cell, regions)])
        check(f'model.inp: nodes of {name}', node_sets['NODES_' + name] == list(nodes))
    wanted = {}
    for structure, inner, outer in truth[5]:
        a, b = sorted((inner, outer))
        key = f'INTERFACE_{b}_0' if a == 0 else f'INTERFACE_{a}_{b}'
        wanted[key] = wanted.get(key, 0) + 1
    check('model.inp: a surface per interface',
          {k: len(v) for k, v in surfaces.items() if k.startswith('INTERFACE')} == wanted)
    check('model.inp: sets of nodes and elements per interface',
          all('NODES_' + k in node_sets and 'ELEMENTS_' + k in sets for k in wanted))
    borders = {f'SURFACE_{name}': sum(len(v) for k, v in surfaces.items() if k.startswith('INTERFACE') and
                                      ((f'REGION_{k.split("_")[1]}' in regions) != (f'REGION_{k.split("_")[2]}' in regions)))
               for name, regions in of_structure.items()}
    check('model.inp: a surface per structure',
          {k: len(v) for k, v in surfaces.items() if k.startswith('SURFACE')} == borders)


def with_numpy_ply(folder, truth):
    """The .ply as the records that its header states: VTK holds the points in single precision only."""
    content = open(os.path.join(folder, 'surface.ply'), 'rb').read()
    head, body = content.split(b'end_header\n', 1)
    wanted = (f'element vertex {len(truth[3])}\nproperty double x\nproperty double y\nproperty double z\n'
              f'element face {len(truth[4])}\nproperty list uchar int vertex_indices\n'
              'property ushort region_in\nproperty ushort region_out\n')
    check('surface.ply: header', head.startswith(b'ply\nformat binary_little_endian 1.0\ncomment ') and
          head.decode().endswith(wanted))
    points = np.frombuffer(body, '<f8', 3 * len(truth[3])).reshape(-1, 3)
    faces = np.frombuffer(body[24 * len(truth[3]):], [('n', 'u1'), ('v', '<i4', 3), ('sides', '<u2', 2)])
    check('surface.ply: points to the last bit', bool((points == truth[3]).all()))
    check('surface.ply: triangles and sides', len(faces) == len(truth[4]) and bool(
        (faces['n'] == 3).all() and (faces['v'] == truth[4]).all() and (faces['sides'] == truth[5][:, 1:]).all()))


def headers(folder):
    for name in sorted(os.listdir(folder)):
        if name in ('truth.txt', 'foreign'):
            continue
        head = open(os.path.join(folder, name), 'rb').read(4000)
        check(f'{name}: SPACE=LPS and UNIT=mm at the head', b'SPACE=LPS' in head and b'UNIT=mm' in head)


def write_foreign(folder, out):
    """The model in the variants of VTK XML, and what meshio makes of it."""
    import meshio
    import vtk
    os.makedirs(out, exist_ok=True)
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.path.join(folder, 'model.vtu'))
    reader.Update()
    for mode in ('Ascii', 'Binary', 'Appended'):
        for compressed in (False, True):
            for order in ('Little', 'Big'):
                for header in (32, 64):
                    for base64 in (False, True) if mode == 'Appended' else (False,):
                        writer = vtk.vtkXMLUnstructuredGridWriter()
                        getattr(writer, f'SetDataModeTo{mode}')()
                        writer.SetEncodeAppendedData(base64)
                        if compressed:
                            writer.SetCompressorTypeToZLib()
                            writer.SetBlockSize(4096)
                        else:
                            writer.SetCompressorTypeToNone()
                        getattr(writer, f'SetByteOrderTo{order}Endian')()
                        getattr(writer, f'SetHeaderTypeToUInt{header}')()
                        writer.SetInputData(reader.GetOutput())
                        name = f'{mode}{"_zlib" if compressed else ""}_{order}_{header}{"_base64" if base64 else ""}.vtu'
                        writer.SetFileName(os.path.join(out, name))
                        check('VTK writes ' + name, writer.Write() == 1)
    mesh = meshio.read(os.path.join(folder, 'model.mesh'))
    labels = np.asarray(mesh.cell_data['medit:ref'][0], np.int32)
    points = np.asarray(mesh.points, float)
    cells = [('tetra', mesh.cells[0].data)]
    for name, options in (('gmsh_text.msh', []), ('gmsh_binary.msh', ['-bin'])):
        run = subprocess.run([shutil.which('gmsh') or 'gmsh', os.path.join(folder, 'model.msh'), '-save', '-format',
                              'msh41', *options, '-o', os.path.join(out, name)], capture_output=True, text=True)
        check('Gmsh writes ' + name, run.returncode == 0)
    meshio.write(os.path.join(out, 'meshio.mesh'), meshio.Mesh(points, cells, cell_data={'medit:ref': [labels]}),
                 float_fmt='.17g')
    meshio.write(os.path.join(out, 'meshio.vtu'), meshio.Mesh(points, cells, cell_data={'structure': [labels]}))
    meshio.write(os.path.join(out, 'meshio.inp'), meshio.Mesh(points, cells), float_fmt='.17g')


def run_unit_test(program, name, folder):
    run = subprocess.run([program, '--gtest_filter=MeshFile.' + name], capture_output=True, text=True,
                         env=dict(os.environ, ANATOMESH_FORMATS_DIR=folder))
    good = run.returncode == 0 and 'Running 1 test ' in run.stdout and 'SKIPPED' not in run.stdout
    check('MeshFile.' + name, good)
    if not good:
        print((run.stdout + run.stderr)[-4000:])


def main():
    program, folder = sys.argv[1:3]
    run_unit_test(program, 'writes_samples_for_foreign_readers', folder)
    truth = read_truth(os.path.join(folder, 'truth.txt'))
    headers(folder)
    with_vtk(folder, truth)
    with_meshio(folder, truth)
    with_gmsh(folder, truth)
    with_own_abaqus(folder, truth)
    with_numpy_ply(folder, truth)
    write_foreign(folder, os.path.join(folder, 'foreign'))
    run_unit_test(program, 'reads_what_foreign_writers_wrote', folder)
    if failures:
        raise SystemExit(f'{len(failures)} differences')
    print('all agree')


if __name__ == '__main__':
    main()
