# What the Unity build lacks on this machine is said once, in a line, and no scene is begun. The embedded engine lacks nothing.
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
