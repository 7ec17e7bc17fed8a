# Processes of both vendors over real sockets.
muster_program(lockstep_peer SOURCES lockstep_peer.cpp LIBS muster_dds)
