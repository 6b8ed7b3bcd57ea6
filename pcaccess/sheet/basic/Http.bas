' Talking to the gateway over HTTP, with nothing but what LibreOffice has itself.
Option Explicit

Function Encoded(sText As String) As String
	' Percent encoding of UTF-8, as an address wants it.
	Dim oFunctions As Object
	oFunctions = createUnoService("com.sun.star.sheet.FunctionAccess")
	Encoded = oFunctions.callFunction("ENCODEURL", Array(sText))
End Function

Function HttpGet(sPath As String, ByRef sText As String) As String
	' What stands at a path of the gateway; the function's value is empty, or says why there is nothing.
	Dim oFiles As Object, oText As Object, sLines As String
	On Error GoTo Failed
	oFiles = createUnoService("com.sun.star.ucb.SimpleFileAccess")
	oText = createUnoService("com.sun.star.io.TextInputStream")
	oText.setInputStream(oFiles.openFileRead(Setting("Gateway") & sPath))
	oText.setEncoding("UTF-8")
	sLines = oText.readLine()
	Do While Not oText.isEOF()
		sLines = sLines & Chr(10) & oText.readLine()
	Loop
	oText.closeInput()
	sText = sLines
	HttpGet = ""
	Exit Function
Failed:
	sText = ""
	HttpGet = Reason(Error$)
End Function

Function HttpPut(sPath As String, sText As String) As String
	' Send a text; empty when it was taken.
	Dim oFiles As Object, oPipe As Object, oText As Object
	On Error GoTo Failed
	oPipe = createUnoService("com.sun.star.io.Pipe")
	oText = createUnoService("com.sun.star.io.TextOutputStream")
	oText.setOutputStream(oPipe)
	oText.setEncoding("UTF-8")
	oText.writeString(sText)
	oText.closeOutput()
	oFiles = createUnoService("com.sun.star.ucb.SimpleFileAccess")
	oFiles.writeFile(Setting("Gateway") & sPath, oPipe)
	HttpPut = ""
	Exit Function
Failed:
	HttpPut = Reason(Error$)
End Function

Function Reason(sError As String) As String
	' LibreOffice tells the HTTP status or the kind of exception, never what the gateway said.
	Dim aKnown As Variant, n As Integer
	aKnown = Array( _
		Array("HTTP/1.1 403", "the gateway refuses it"), _
		Array("HTTP/1.1 404", "there is no such item"), _
		Array("Not found", "there is no such item"), _
		Array("HTTP/1.1 422", "the value does not fit"), _
		Array("HTTP/1.1 421", "the gateway serves this machine only: use 127.0.0.1"), _
		Array("HTTP/1.1 502", "the PLC refuses it"), _
		Array("HTTP/1.1 503", "the PLC is not connected"), _
		Array("HTTP/1.1 504", "the PLC did not answer"), _
		Array("HTTP/1.1 401", "the server wants a user name and a password: is it pcaccess?"), _
		Array("NetworkConnect", "the gateway does not answer: is pcaccess running?"), _
		Array("NetworkResolve", "there is no such machine"), _
		Array("NetworkRead", "the gateway does not answer: is pcaccess running?"))
	For n = 0 To UBound(aKnown)
		If InStr(sError, aKnown(n)(0)) > 0 Then
			Reason = aKnown(n)(1)
			Exit Function
		End If
	Next n
	Reason = sError
End Function

Function Member(sJson As String, sName As String) As String
	' The member of a flat JSON object as text; empty when it is null or not there.
	Dim nAt As Long, nEnd As Long, sSign As String, sText As String
	nAt = InStr(sJson, """" & sName & """:")
	If nAt = 0 Then Exit Function
	nAt = nAt + Len(sName) + 3
	If Mid(sJson, nAt, 1) <> """" Then
		nEnd = nAt
		Do While nEnd <= Len(sJson) And InStr(",}]", Mid(sJson, nEnd, 1)) = 0
			nEnd = nEnd + 1
		Loop
		sText = Mid(sJson, nAt, nEnd - nAt)
		If sText <> "null" Then Member = sText
		Exit Function
	End If
	nAt = nAt + 1
	Do While nAt <= Len(sJson)
		sSign = Mid(sJson, nAt, 1)
		If sSign = """" Then Exit Do
		If sSign = "\" Then
			nAt = nAt + 1
			sSign = Mid(sJson, nAt, 1)
			If sSign = "u" Then
				sSign = Chr(CLng("&H" & Mid(sJson, nAt + 1, 4)))
				nAt = nAt + 4
			ElseIf InStr("nrt", sSign) > 0 Then
				sSign = " "
			End If
		End If
		sText = sText & sSign
		nAt = nAt + 1
	Loop
	Member = sText
End Function
