"""Curves as instruments and spreadsheets write them, and files that must be refused."""

import numpy as np

DEPTH = np.array([-0.125, 0.25, 1.5, 0.75]) * 1e-6
FORCE = np.array([0.0615, -0.25, 1000.5, 1e-3]) * 1e-3
RIGHT = [  # name, text, encoding: DEPTH in µm and FORCE in mN/m
    (
        "semicolons and decimal commas",
        "depth [µm];force [mN/m]\n-0,1250;0,06150\n0,25;-0,25\n1,5;1000,5\n0,75;1,0E-03\n",
        "utf-8",
    ),
    (
        "tabs, carriage returns, Windows's encoding",
        "Depth (µm)\tForce (mN/m)\r\n-0.125\t.0615\r\n0.25\t-0.25\r\n1.5\t1000.5\r\n0.75\t1e-3\r\n",
        "cp1252",
    ),
    (
        "tabs and decimal commas in UTF-16, as Excel saves Unicode text",
        "depth [µm]\tforce [mN/m]\r\n-0,125\t0,0615\r\n0,25\t-0,25\r\n1,5\t1000,5\r\n"
        "0,75\t0,001\r\n",
        "utf-16",
    ),
    (
        "UTF-16 without a mark",
        "depth [µm],force [mN/m]\n-0.125,0.0615\n0.25,-0.25\n1.5,1000.5\n0.75,0.001\n",
        "utf-16-le",
    ),
    (
        "quoted decimal commas between commas",
        '"depth [µm]","force [mN/m]"\n"-0,125","0,0615"\n'
        '"0,25","-0,25"\n"1,5","1000,5"\n"0,75","0,001"\n',
        "utf-8-sig",
    ),
    (
        "a preamble of words and numbers",
        "Instrument: 7;\nDate;12.03.2024\nPoints;4\n\ndepth [µm];force [mN/m]\n"
        "-0.125;0.0615\n0.25;-0.25\n1.5;1000.5\n0.75;0.001\n",
        "latin-1",
    ),
    (
        "units in a second row",
        "Time;Depth;Force\ns;µm;mN/m\n0;-0,125;0,0615\n1;0,25;-0,25\n2;1,5;1000,5\n3;0,75;0,001\n",
        "cp1252",
    ),
    (
        "units in brackets in a second row, blanks in columns",
        "  depth      force\n  [µm]      [mN/m]\n -0.125     0.0615\n  0.25     -0.25\n"
        "  1.5    1000.5\n  0.75      0.001\n",
        "utf-8",
    ),
    (
        "three columns, the first of clock times",
        "Zeit;depth [nm];force [µN/mm]\n12:00:01,5;-125;0,0615\n12:00:02,5;250;-0,25\n"
        "12:00:03,5;1500;1000,5\n12:00:04,5;750;0,001\n",
        "utf-8",
    ),
    (
        "a delimiter behind the last cell",
        "depth [µm];force [mN/m];\n-0.125;0.0615;\n0.25;-0.25;\n1.5;1000.5;\n0.75;0.001;\n;;\n",
        "utf-8",
    ),
    (
        "names in a comment, as numpy.savetxt writes them",
        "# depth [µm],force [N/m]\n-1.25e-01,6.15e-05\n2.5e-01,-2.5e-04\n1.5e+00,1.0005e+00\n"
        "7.5e-01,1e-06\n",
        "utf-8",
    ),
    (
        "a spreadsheet's note of its delimiter, a true minus",
        "sep=;\r\ndepth / µm;force / mN/m\r\n\u22120,125;0,0615\r\n0,25;\u22120,25\r\n"
        "1,5;1000,5\r\n0,75;0,001\r\n",
        "utf-8",
    ),
    (
        "old Macintosh line ends",
        "depth in µm,force in mN/m\r-0.125,0.0615\r0.25,-0.25\r1.5,1000.5\r0.75,0.001",
        "utf-8",
    ),
]
WRONG = [  # name, bytes, what is said
    ("empty", b" \r\n", "is empty; give a file with columns of numbers"),
    ("binary", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\2\3", "is no text"),
    ("words", b"depth [m], force [N/m]\nsee the other file\n", "no line has two numbers"),
    (
        "ragged",
        b"depth [m];force [N/m]\n1,5;2\n2,5;3;4\n3,5;4\n",
        "line 3: 3 cells where line 1 has 2; .*'2,5;3;4'",
    ),
    (
        "a decimal comma between commas",
        b"depth [m],force [N/m]\n1,5,2,5\n2,5,3,5\n",
        "line 1: 2 cells where line 2 has 4",
    ),
    (
        "first row ragged",
        b"depth [m];force [N/m]\n1\n2;3\n3;4\n",
        "line 2: 1 cell where line 3 has 2",
    ),
    (
        "both decimal marks",
        b"no;depth [m];force [N/m]\n1;1,5;2.5\n2;2,5;3.5\n",
        "line 2: '.*' has the mark '.', other cells have",
    ),
    (
        "thousands or decimals",
        b"depth [nm];force [N/m]\n-1,250;2,500\n-2,250;3,500\n",
        "line 2: '-1,250' may be a number with three decimals or one in thousands",
    ),
    (
        "thousands and decimals",
        b"depth [nm];force [N/m]\n1.234,5;2,5\n2,5;3,5\n3,5;4,5\n",
        "line 2: '1.234,5' must be a number with the decimal mark ','",
    ),
    (
        "a word among the numbers",
        b"depth [m]\tforce [N/m]\n1\t2\n2\toverload\n3\t4\n",
        "line 3: force = 'overload' must be a finite number",
    ),
    (
        "a missing cell",
        b"depth [m]\tforce [N/m]\n1\t2\n2\t\n3\t4\n",
        "line 3: force = '' must be a finite number",
    ),
    (
        "not finite",
        b"depth [m]\tforce [N/m]\n1\t2\n2\t1e999\n3\t4\n",
        "line 3: force = '1e999' must be a finite number",
    ),
    (
        "two blocks",
        b"depth [m];force [N/m]\n1;2\n2;3\nunloading\n1;1\n0;0\n",
        "line 4: 1 cell where line 1 has 2; .*'unloading'",
    ),
    (
        "two forces",
        b"depth [m];force [N/m];force [N/m]\n1;2;3\n2;3;4\n",
        "2 columns 'force': its line 1 names 3 columns",
    ),
    ("no names", b"1;2\n2;3\n", "no column 'depth': it has 2 columns without names"),
    ("no units", b"depth;force\n1;2\n2;3\n", "column 'depth' has no unit"),
    ("megametres", b"depth [Mm];force [N/m]\n1;2\n2;3\n", "the unit 'Mm' of the depth"),
    ("newtons", b"depth [m];force [N]\n1;2\n2;3\n", "the force is in newtons.*--width"),
]
