#!/usr/bin/python3
"""Quadratic elements, grey values, materials and sets in every format, against readers that share no code with ours.

Usage: elements_test.py IO_MESH_TEST DIR

IO_MESH_TEST writes quadratic.{vtu,msh,inp,feb} and quadratic.txt into DIR; VTK, meshio, Gmsh and Python's XML parser read
them. The order of the nodes within an element is checked by where they lie: near the middles of the edges that the format's
manual names. Exit code 0 when all agree.
"""
import os
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np

VTK_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]  # Abaqus and FEBio too
GMSH_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)]
OUR_EDGES = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
failures = []


def check(what, condition):
    print(('ok   ' if condition else 'FAIL ') + what)
    if not condition:
        failures.append(what)


class Truth:
    def __init__(self, path):
        rows = [line.split() for line in open(path).read().splitlines()]
        n, k, m = map(int, rows[0])
        self.points = np.array([[float.fromhex(x) for x in row] for row in rows[1:1 + n + k]])
        cells = rows[1 + n + k:]
        assert len(cells) == m
        self.corners = np.array([[int(x) for x in row[:4]] for row in cells])
        mids = np.array([[int(x) + n for x in row[4:10]] for row in cells])
        self.region = np.array([int(row[10]) for row in cells])
        self.material = np.array([int(row[11]) for row in cells])
        self.grey = np.array([float.fromhex(row[12]) for row in cells])
        self.vtk = np.c_[self.corners, mids[:, [OUR_EDGES.index(e) for e in VTK_EDGES]]]
        self.order = np.lexsort(self.corners.T[::-1])


def same(a, b):
    a, b = np.asarray(a), np.asarray(b)
    return a.shape == b.shape and bool((a == b).all())


def near_the_middles(what, points, cells, edges):
    middles = np.stack([points[cells[:, [a, b]]].mean(1) for a, b in edges], 1)
    check(f'{what}: mid-nodes near the middles of the edges', np.abs(points[cells[:, 4:]] - middles).max() < 0.011)


def with_vtk(folder, truth):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.path.join(folder, 'quadratic.vtu'))
    reader.Update()
    grid = reader.GetOutput()
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 10)
    points = vtk_to_numpy(grid.GetPoints().GetData())
    data = grid.GetCellData()
    check('VTK: quadratic tetrahedra', bool((vtk_to_numpy(grid.GetCellTypesArray()) == 24).all()))
    check('VTK: points to the last bit', same(points, truth.points))
    check('VTK: connectivity', same(cells, truth.vtk))
    check('VTK: grey', same(vtk_to_numpy(data.GetArray('grey')), truth.grey))
    check('VTK: material', same(vtk_to_numpy(data.GetArray('material')), truth.material))
    check('VTK: young_mpa', same(vtk_to_numpy(data.GetArray('young_mpa')), np.where(truth.material == 1, 12000.5, 1 / 3)))
    near_the_middles('VTK', points, cells, VTK_EDGES)
    volume = sum(abs(vtk.vtkMeshQuality.TetVolume(grid.GetCell(i))) for i in range(5))
    check('VTK: cells have a volume', volume > 0)


def with_meshio(folder, truth):
    import meshio
    mesh = meshio.read(os.path.join(folder, 'one_region.msh'))
    check('meshio .msh: points to the last bit', same(mesh.points, truth.points))
    # meshio turns Gmsh's order into VTK's.
    check('meshio .msh: connectivity', [block.type for block in mesh.cells] == ['tetra10'] and same(mesh.cells[0].data, truth.vtk))
    check('meshio .msh: grey', same(mesh.cell_data['grey'][0], truth.grey))
    check('meshio .msh: material', same(mesh.cell_data['material'][0], truth.material))
    mesh = meshio.read(os.path.join(folder, 'quadratic.inp'))
    cells = np.vstack([block.data for block in mesh.cells if block.type == 'tetra10'])
    order = np.lexsort(cells[:, :4].T[::-1])
    check('meshio .inp: points to the last bit', same(mesh.points, truth.points))
    check('meshio .inp: connectivity', same(cells[order], truth.vtk[truth.order]))
    near_the_middles('meshio .inp', mesh.points, cells, VTK_EDGES)


def with_gmsh(folder, truth):
    import meshio
    program = shutil.which('gmsh')
    if not program:
        check('gmsh is installed', False)
        return
    with tempfile.TemporaryDirectory() as out:
        written = os.path.join(out, 'anew.msh')
        run = subprocess.run([program, os.path.join(folder, 'quadratic.msh'), '-save', '-format', 'msh22', '-o', written,
                              '-save_all', '-v', '3'], capture_output=True, text=True)
        text = run.stdout + run.stderr
        good = run.returncode == 0 and 'Error' not in text and 'Warning' not in text and os.path.exists(written)
        check('Gmsh: reads without a warning', good)
        if not good:
            print(text[-2000:])
            return
        lines = open(written).read().splitlines()
        start = lines.index('$Elements') + 2
        rows = [list(map(int, line.split())) for line in lines[start:start + int(lines[start - 1])]]
        cells = np.array([row[-10:] for row in rows if row[1] == 11]) - 1
        check('Gmsh: second-order tetrahedra', len(cells) == len(truth.corners))
        mesh = meshio.read(written)
        near_the_middles('Gmsh', mesh.points, cells, GMSH_EDGES)


def views(folder, truth):
    """The views of a model of two regions, by their records."""
    content = open(os.path.join(folder, 'quadratic.msh'), 'rb').read()
    for name, wanted in (('grey', truth.grey), ('material', truth.material)):
        head = b'$ElementData\n1\n"%s"\n1\n0\n3\n0\n1\n%d\n' % (name.encode(), len(wanted))
        start = content.index(head) + len(head)
        records = np.frombuffer(content[start:start + 12 * len(wanted)], [('tag', '<i4'), ('value', '<f8')])
        check(f'.msh: view {name}', same(np.sort(records['tag']), np.arange(1, len(wanted) + 1)) and
              same(records['value'], wanted[records['tag'] - 1]))


def with_xml(folder, truth):
    root = ElementTree.parse(os.path.join(folder, 'quadratic.feb')).getroot()
    check('.feb: febio_spec 4.0', root.tag == 'febio_spec' and root.get('version') == '4.0')
    head = open(os.path.join(folder, 'quadratic.feb'), encoding='utf-8').read(4000)
    check('.feb: SPACE=LPS and UNIT=mm', 'SPACE=LPS' in head and 'UNIT=mm' in head)
    check('.feb: sections in FEBio\'s order', [child.tag for child in root] ==
          ['Module', 'Material', 'Mesh', 'MeshDomains', 'MeshData'])
    mesh = root.find('Mesh')
    numbers = lambda element: [int(x) for x in element.text.split(',')]
    nodes = mesh.find('Nodes')
    points = np.array([[float(x) for x in node.text.split(',')] for node in nodes])
    check('.feb: points to the last bit', same(points, truth.points) and [int(n.get('id')) for n in nodes] ==
          list(range(1, len(points) + 1)))
    cells = np.zeros((len(truth.corners), 10), int)
    part_of = np.full(len(cells), '', object)
    for part in mesh.findall('Elements'):
        for element in part:
            cells[int(element.get('id')) - 1] = np.array(numbers(element)) - 1
            part_of[int(element.get('id')) - 1] = part.get('name')
    check('.feb: tet10', {part.get('type') for part in mesh.findall('Elements')} == {'tet10'})
    check('.feb: connectivity', same(cells, truth.vtk))
    wanted = np.array([f'REGION_{r}_MATERIAL_{m}' for r, m in zip(truth.region, truth.material)], object)
    check('.feb: parts by region and material', bool((part_of == wanted).all()))
    materials = {m.get('name'): float(m.find('E').text) for m in root.find('Material')}
    check('.feb: materials', materials == {'MATERIAL_1': 12000.5, 'MATERIAL_2': 1 / 3})
    domains = {d.get('name'): d.get('mat') for d in root.find('MeshDomains')}
    check('.feb: a domain per part', domains == {name: 'MATERIAL' + name.split('MATERIAL')[1] for name in set(wanted)})
    grey = [float(e.text) for e in root.find('MeshData/ElementData')]
    check('.feb: grey', same(grey, truth.grey))
    node_sets = {s.get('name'): np.array(numbers(s)) - 1 for s in mesh.findall('NodeSet')}
    element_sets = {s.get('name'): np.array(numbers(s)) - 1 for s in mesh.findall('ElementSet')}
    check('.feb: elements of the structures', same(element_sets['STRUCTURE_5'], np.arange(len(cells))) and
          same(element_sets['STRUCTURE_7'], np.flatnonzero(truth.region == 2)))
    check('.feb: nodes of a structure', same(node_sets['NODES_STRUCTURE_7'], np.unique(cells[truth.region == 2])))
    for surface in mesh.findall('Surface'):
        faces = np.array([numbers(face) for face in surface]) - 1
        name = surface.get('name')
        check(f'.feb: {name} of tri6', {face.tag for face in surface} == {'tri6'})
        middles = np.stack([points[faces[:, [k, (k + 1) % 3]]].mean(1) for k in range(3)], 1)
        check(f'.feb: {name}: mid-nodes on their edges', np.abs(points[faces[:, 3:]] - middles).max() < 0.011)
        # Closed, and counter-clockwise from outside: the volume inside is positive.
        a, b, c = (points[faces[:, k]] for k in range(3))
        volume = np.einsum('ij,ij->i', a, np.cross(b, c)).sum() / 6
        straight = np.einsum('ij,ij->i', np.cross(points[cells[:, 1]] - points[cells[:, 0]], points[cells[:, 2]] - points[cells[:, 0]]),
                             points[cells[:, 3]] - points[cells[:, 0]]) / 6
        inside = {'SURFACE_STRUCTURE_5': truth.region > 0, 'SURFACE_STRUCTURE_7': truth.region == 2, 'INTERFACE_1_0': truth.region > 0,
                  'INTERFACE_1_2': truth.region == 2}[name]
        sign = -1 if name == 'INTERFACE_1_2' else 1  # seen from region 1, which lies around region 2
        check(f'.feb: {name}: encloses its volume', abs(sign * volume / straight[inside].sum() - 1) < 1e-9)


def main():
    program, folder = sys.argv[1:3]
    run = subprocess.run([program, '--gtest_filter=QuadraticFiles.O02_writes_samples_for_foreign_readers'], capture_output=True,
                         text=True, env=dict(os.environ, ANATOMESH_FORMATS_DIR=folder))
    good = run.returncode == 0 and 'Running 1 test ' in run.stdout and 'SKIPPED' not in run.stdout
    check('QuadraticFiles.O02_writes_samples_for_foreign_readers', good)
    if not good:
        raise SystemExit(run.stdout + run.stderr)
    truth = Truth(os.path.join(folder, 'quadratic.txt'))
    with_vtk(folder, truth)
    with_meshio(folder, truth)
    with_gmsh(folder, truth)
    views(folder, truth)
    with_xml(folder, truth)
    if failures:
        raise SystemExit(f'{len(failures)} differences')
    print('all agree')


if __name__ == '__main__':
    main()
