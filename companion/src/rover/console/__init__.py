"""The operator's page: a server beside the missions, which are processes of their own and need it for nothing.

What it says to a mission goes over the socket of `rover tell`; what it shows comes over the same one. What the commands
of `rover` do is done here by the same functions. Comes with the extra [console].
"""
