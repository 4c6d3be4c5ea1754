# Checks the Unity build's requirements once, before any scene; a missing one is one line. The embedded engine has none.
rule simulator:
    output:
        simulator="results/simulator.txt",
    log:
        "logs/simulator.log",
    resources:
        gpu=GPU,
    params:
        constants=stage("simulator"),
    script:
        "../scripts/simulator.py"
